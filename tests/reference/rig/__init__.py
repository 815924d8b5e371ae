"""A rig of its own: readings of a drive in which effects are hidden.

A second forward model of the whole drive, for all readings of a table at once, which makes the
data that a diagnosis is tried on. It shares nothing with the product. Read it in this order:

    mesh        meshing points of all readings and their equilibrium
    bench       Rows (a table without its angle), Bench (what effects act on), simulate
    kinds       what an effect is
    effects     every effect by its id: series, loads (with friction), and outside for those that no
                library holds
    noise       what an instrument adds; instrument: several of it together, artefacts, displays
    springs     torsion springs: loops, play, curves
    campaign    drives, test plans, campaigns with a sealed truth, on disk

Campaigns at a stated strength are made of it in benches/trial. SI units and radians; columns of
tables carry their unit.
"""

from reference.rig.bench import ARCSEC, Rows, drive_of, held_Nm, simulate

__all__ = ["ARCSEC", "Rows", "drive_of", "held_Nm", "simulate"]
