"""Solid materials by name."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Solid:
    """A solid material: Young's modulus of small strains (Pa), density (kg/m^3), and where the numbers come from."""

    young: float
    density: float
    source: str


# Soft to stiff. Where a source gives a range the middle is taken.
SOLIDS = {
    "jelly": Solid(5e3, 1000.0, "Gelatin of 5 % (Hall et al. 1997: 1 to 10 kPa)"),
    "flesh": Solid(20e3, 1060.0, "Relaxed muscle across its fibres (McKee et al. 2011: indentation in the tens of kPa)"),
    "skin": Solid(56e3, 1100.0, "Forearm under suction (Hendriks et al. 2003: 56 kPa)"),
    "rubber": Solid(1.1e6, 1100.0, "Shore A 30 (Gent 1958)"),
}
