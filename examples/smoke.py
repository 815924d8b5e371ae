"""What a freshly installed wheel must be able to do, without plotting or test tools."""

import subprocess
import sys
import sysconfig
from pathlib import Path

import cbpt

here = Path(__file__).parent
solution = cbpt.Drive.from_toml(cbpt.example_case()).solve(torque_Nm=5, preload_N=600)
assert solution.elastic_angle_arcsec is not None
assert abs(solution.elastic_angle_arcsec - 12.4604549) < 1e-6, solution
comparison = cbpt.compare(here / "campaign.toml", here / "campaign.csv")
assert comparison.overall is not None
assert comparison.overall.readings == 396
assert Path(cbpt.__file__).with_name("py.typed").exists()
assert Path(cbpt.__file__).with_name("_core.pyi").exists()
assert "matplotlib" not in sys.modules

command = Path(sysconfig.get_path("scripts")) / "cbpt"
for arguments in (["--version"], ["check", str(here / "base_case.toml")]):
    subprocess.run([command, *arguments], check=True)
print(f"cbpt {cbpt.__version__}: the wheel works")
