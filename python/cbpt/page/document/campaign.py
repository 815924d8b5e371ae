"""What the campaign that was read could see and tell apart, for its page."""

from __future__ import annotations

from cbpt.errors import CbptError
from cbpt.lab.diagnosis.diagnosis import Diagnosis
from cbpt.lab.experiment.isolability import isolability
from cbpt.lab.experiment.isolability_text import sized
from cbpt.lab.selection.competition import Progress
from cbpt.page.document.document import Isolability


def campaign_isolability(d: Diagnosis, progress: Progress | None = None) -> Isolability:
    """What the diagnosed campaign could see and tell apart."""
    u = None
    if d.readings.u_elastic_angle_arcsec is None:
        u = d.to_dict()["noise"]["u_estimated_arcsec"]
    try:
        found = isolability(d.case, d.readings, u_elastic_angle_arcsec=u, progress=progress)
    except CbptError as error:
        return Isolability(None, str(error))
    document = found.to_dict()
    for entry, seen in zip(document["effects"], found.seen, strict=True):
        sizes = (seen.smallest["even"], seen.smallest["sure"])
        number, (even, sure) = sized(seen.form, sizes)
        entry["shown"] = {"number": number, "even": even, "sure": sure}
    return Isolability(document, None)
