"""Every threshold by which `evenspin gap CASE_DIR` decides; docs/gap-thresholds.md is made from these tables.

Costs are robust chi-squares of all features (evidence.robust_cost). "Excess" is cost beyond what simulated healthy
units have.
"""

from evenspin.gap import thresholds_effects, thresholds_evidence, thresholds_records

SECTIONS = (thresholds_effects.SECTION, thresholds_evidence.SECTION, thresholds_records.SECTION)

__all__ = ["SECTIONS"]
