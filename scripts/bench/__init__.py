"""The baselines that scripts/bench_kinematics.py measures pinmech against."""
