"""The main job on bundled input, as `make demo` runs it: where a model fails, which effect is
missing, the error with it added, and what is said when nothing in the library fits."""

import sys
from pathlib import Path

import cbpt

HERE = Path(__file__).parent


def main(out: Path) -> None:
    out.mkdir(parents=True, exist_ok=True)
    case, table = HERE / "campaign.toml", HERE / "campaign.csv"
    readings = cbpt.read_readings(table)
    assert readings.preload_N is not None
    # One preload level is kept back: the model is never fitted to it.
    kept_back = readings.preload_N == readings.preload_N.max()
    known, unseen = readings.select(~kept_back), readings.select(kept_back)

    title(f"1. A drive, {len(known)} readings of it, and the model: where does it fail?")
    print(cbpt.compare(case, known))

    title("2. Which effect is missing?")
    answer = cbpt.diagnose(case, known)
    print(answer)
    picture = out / "diagnosis.svg"
    answer.plot(picture)

    # The most probable combination, whether it is certain or has rivals.
    effects = answer.verdict.names
    title(f"3. {' and '.join(effects)} added, and {len(unseen)} readings it has never seen")
    fitted = cbpt.fit(case, known, effects)
    print(fitted)
    (out / "campaign_with_effect.toml").write_text(fitted.case.to_toml(), encoding="utf-8")
    before, after = cbpt.compare(case, unseen), cbpt.compare(fitted.case, unseen)
    print(
        f"\nOn the readings kept back ({readings.preload_N.max():g} N): "
        f"{error(before)} arcsec before, {error(after)} arcsec with {' and '.join(effects)}."
    )

    title("4. Another drive, with something that no library holds")
    strange = cbpt.diagnose(HERE / "damaged.toml", HERE / "damaged.csv")
    print(strange)
    strange.plot(out / "damaged.svg")

    print(f"\nPictures: {picture} and {out / 'damaged.svg'}")
    print(f"The case with the effect in it: {out / 'campaign_with_effect.toml'}")


def error(comparison: cbpt.Comparison) -> str:
    """Root mean square of the residual, arcsec."""
    assert comparison.overall is not None
    return f"{comparison.overall.rmse_arcsec:.2f}"


def title(text: str) -> None:
    print(f"\n{text}\n{'=' * len(text)}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out"))
