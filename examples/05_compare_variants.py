"""The same world, the same team, other rules: compare the planner's variants.

python examples/05_compare_variants.py
"""

import cavalcade as cv

VARIANTS = ("cavalcade", "published", "fixed-roles", "no-lookahead", "no-springs")

print(f"{'variant':14} {'reason':10} {'time s':>7} {'error m':>8} {'gap m':>6} {'leaders':>8}")
for variant in VARIANTS:
    scenario = cv.load_scenario("cone", overrides=[f"planner.variant={variant}"], seed=1)
    summary = cv.run(scenario).summary  # without a folder nothing is written
    print(
        f"{variant:14} {summary['reason']:10} {summary['sim_time_s']:7.1f} "
        f"{summary['formation_error_m']['mean']:8.3f} {summary['min_footprint_gap_m']:6.2f} "
        f"{1 + summary['leader_changes']:8}"
    )
