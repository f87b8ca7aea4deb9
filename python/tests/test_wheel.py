"""What is said of a wheel that carries what it must not."""

import importlib.util
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import pliant

HERE = Path(__file__).resolve().parents[1]
if sys.platform != "linux" or shutil.which("readelf") is None:
    pytest.skip("wheels are checked by readelf, on Linux", allow_module_level=True)


@pytest.fixture(scope="module")
def check():
    """The check of CI."""
    spec = importlib.util.spec_from_file_location("check_wheel", HERE / "check_wheel.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def made(folder: Path, tag: str, libraries: list[Path], filling: int = 0) -> Path:
    """A wheel of these libraries."""
    path = folder / f"pliant-0.1.0-cp311-abi3-{tag}.whl"
    with zipfile.ZipFile(path, "w") as archive:
        for library in libraries:
            archive.write(library, f"pliant/plugins/{library.name}", zipfile.ZIP_DEFLATED)
        archive.writestr("filling", bytes(filling))
    return path


def built(folder: Path, name: str, code: str, *options: str) -> Path:
    """A library that a compiler makes of some C."""
    compiler = shutil.which("cc") or pytest.skip("no C compiler")
    source, library = folder / f"{name}.c", folder / f"{name}.so"
    source.write_text(code)
    subprocess.run([compiler, "-shared", "-fPIC", source, "-o", library, *options], check=True)
    return library


def test_the_libraries_of_the_installed_package_are_taken(check, tmp_path):
    package = Path(pliant.__file__).parent
    libraries = sorted(package.rglob("*.so"))
    assert len(libraries) > 8 and check.check(made(tmp_path, "linux_x86_64", libraries)) == []


def test_what_a_wheel_must_not_carry_is_named(check, tmp_path):
    plain = built(tmp_path, "plain", "int one(void) { return 1; }")
    other = built(tmp_path, "other", "extern int one(void); int two(void) { return one(); }", plain)
    good = [plain, built(tmp_path, "also", "int three(void) { return 3; }")]
    assert check.check(made(tmp_path, "manylinux_2_17_x86_64", good)) == []
    for tag, libraries, filling, says in [
        ("linux_x86_64", [plain, other], 0, "plain.so"),
        ("linux_x86_64", good, check.LARGEST, "allowed is 10000000"),
        ("linux_x86_64", [plain], 0, "no libraries of plugins"),
        ("win_amd64", good, 0, "`win_amd64`"),
    ]:
        wrong = check.check(made(tmp_path, tag, libraries, filling))
        assert len(wrong) == 1 and says in wrong[0], wrong
    # A function that came with a C library of its own version: glibc 2.34 has its threads in libc.
    code = "#define _GNU_SOURCE\n#include <math.h>\n#include <pthread.h>\nint t(pthread_t p) { return pthread_join(p, 0); }"
    newer = built(tmp_path, "newer", code)
    if "GLIBC_2.34" not in check.readelf(newer, "--version-info"):
        pytest.skip("the C library here is older than 2.34")
    wrong = check.check(made(tmp_path, "manylinux_2_17_x86_64", [newer, plain]))
    assert len(wrong) == 1 and "promises glibc 2.17" in wrong[0] and "need 2.34" in wrong[0]
