"""Whole drives against the independent reference model."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from cbpt import Drive
from common.drives import (
    ARCSEC,
    CaseDict,
)

REFERENCE: dict[str, Any] = json.loads(
    (Path(__file__).parents[1] / "data" / "golden" / "reference.json").read_text()
)


def why_no_drive(drive: CaseDict) -> str | None:
    """Why the two pairs of a drive of the file cannot belong to one `Drive`."""
    first, second = drive["deceleration"], drive["equal_speed"]
    eccentricity = first["short_amplitude"] * first["rolling_radius_m"]
    if first["material"] != second["material"]:
        return "its pairs differ in material"
    if drive["equal_speed_pair"] == "ring_groove" and not math.isclose(
        second["ring_radius_m"], eccentricity
    ):
        return "its ring radius is not the eccentricity"
    return None


def case_of_the_reference(drive: CaseDict) -> CaseDict:
    """A drive of the file as a case."""
    first, second = drive["deceleration"], drive["equal_speed"]
    ring = drive["equal_speed_pair"] == "ring_groove"
    material = first["material"]
    return {
        "track_curvature": first["track_curvature"],
        "material": {
            "ball_youngs_modulus_Pa": material["ball_modulus_Pa"],
            "ball_poissons_ratio": material["ball_poisson"],
            "plate_youngs_modulus_Pa": material["plate_modulus_Pa"],
            "plate_poissons_ratio": material["plate_poisson"],
        },
        "deceleration": {
            "ball_count": first["ball_count"],
            "short_amplitude_coefficient": first["short_amplitude"],
            "rolling_circle_radius_m": first["rolling_radius_m"],
            "ball_radius_m": first["ball_radius_m"],
            "groove_conformity": first["conformity"],
            "contact_angle_rad": first["contact_angle_rad"],
            "output_plate": first["output"],
        },
        "equal_speed": {
            "kind": drive["equal_speed_pair"],
            "ball_count": second["ball_count"],
            "pitch_radius_m": second["pitch_radius_m"],
            "ball_radius_m": second["ball_radius_m"],
            "groove_conformity": second["conformity"],
            **(
                {
                    "outside_contact_angle_rad": second["contact_angle_outside_rad"],
                    "inside_contact_angle_rad": second["contact_angle_inside_rad"],
                }
                if ring
                else {"contact_angle_rad": second["contact_angle_rad"]}
            ),
        },
    }


# By name, so that no drive goes missing unseen; the Rust test compares these too, pair by pair.
NO_DRIVE = {
    "5 and 9 balls, no inside wall, crank at 0.45 rad": "its ring radius is not the eccentricity",
    "5 and 9 balls, no inside wall, crank at -1.3 rad": "its ring radius is not the eccentricity",
    "8 and 9 balls, odd cross-slide, ceramic, crank at 0.2 rad": "its pairs differ in material",
    "8 and 9 balls, odd cross-slide, ceramic, crank at 4 rad": "its pairs differ in material",
    "33 and 8 balls, unlike angles, crank at 0.9 rad": "its ring radius is not the eccentricity",
}


@pytest.mark.parametrize("expected", REFERENCE["drives"], ids=lambda drive: drive["id"])
def test_whole_drives_agree_with_the_reference(expected: CaseDict) -> None:
    """Angles, statuses and thresholds of an independent model, to 1e-8."""
    if expected["id"] in NO_DRIVE:
        pytest.skip(NO_DRIVE[expected["id"]])
    drive = Drive.from_dict(case_of_the_reference(expected))
    crank = math.degrees(expected["crank_angle_rad"])
    assert drive.transmission_ratio == pytest.approx(expected["ratio"], rel=1e-14)
    for load in expected["solutions"]:
        s = drive.solve(load["torque_Nm"], load["preload_N"], crank)
        if load["status"] == "refused":
            assert (s.status, s.elastic_angle_rad) == ("beyond_hold", None)
            assert s.hold_preload_N == pytest.approx(load["preload_that_holds_N"], rel=1e-8)
            continue
        assert s.status == load["status"]
        assert s.deceleration is not None
        assert s.equal_speed is not None
        assert s.alpha_equal_speed_arcsec is not None
        assert s.enclosure is not None
        # The reference solves its own equations, from its own stiffnesses, to 14 digits.
        for bound in s.enclosure.elastic_angle_rad:
            assert bound == pytest.approx(load["total_rad"], rel=1e-11, abs=load["floor_rad"])
        for found, name in [
            (s.elastic_angle_rad, "total_rad"),
            (s.deceleration.angle_rad, "deceleration_rad"),
            (s.equal_speed.angle_rad, "equal_speed_rad"),
            (s.alpha_equal_speed_arcsec * ARCSEC, "equal_speed_at_output_rad"),
        ]:
            assert found == pytest.approx(load[name], rel=1e-8, abs=load["floor_rad"]), name
    limits = [(expected["limits"], crank), (expected["limits_over_period"], None)]
    for limit, angle in limits:
        if limit is not None:
            thresholds = drive.preload(limit["torque_Nm"], angle).drive
            for name in ("hold_N", "continuous_N", "zero_backlash_N"):
                assert getattr(thresholds, name) == pytest.approx(limit[name], rel=1e-8), name


def test_only_what_is_no_drive_is_left_to_the_rust_test() -> None:
    reasons = {drive["id"]: why_no_drive(drive) for drive in REFERENCE["drives"]}
    assert {name: why for name, why in reasons.items() if why} == NO_DRIVE
