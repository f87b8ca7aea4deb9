"""What is said of a wheel that carries what it must not."""

import base64
import hashlib
import importlib.util
import platform
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


def needed_glibc(check, folder: Path, library: Path) -> tuple[int, int]:
    """The version of glibc that a library needs."""
    [(_, version)] = check.needs(made(folder, "linux_x86_64", [library])).values()
    return version


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
    if needed_glibc(check, tmp_path, newer) < (2, 34):
        pytest.skip("the C library here is older than 2.34")
    wrong = check.check(made(tmp_path, "manylinux_2_17_x86_64", [newer, plain]))
    assert len(wrong) == 1 and "promises glibc 2.17" in wrong[0] and "need 2.34" in wrong[0]


def test_a_wheel_is_named_by_the_oldest_platform_that_it_runs_on(check, tmp_path):
    pytest.importorskip("wheel")
    import manylinux

    tag = f"linux_{platform.machine()}"
    plain = built(tmp_path, "plain", "#include <math.h>\ndouble one(double x) { return floor(x); }", "-lm")
    major, minor = needed_glibc(check, tmp_path, plain)
    renamed = manylinux.retag(with_metadata(made(tmp_path, tag, [plain]), tag))
    assert renamed.name == f"pliant-0.1.0-cp311-abi3-manylinux_{major}_{minor}_{platform.machine()}.whl"
    assert renamed.is_file() and not (tmp_path / f"pliant-0.1.0-cp311-abi3-{tag}.whl").exists()
    with zipfile.ZipFile(renamed) as archive:
        assert f"Tag: cp311-abi3-manylinux_{major}_{minor}_" in archive.read("pliant-0.1.0.dist-info/WHEEL").decode()
        assert archive.testzip() is None
    # One that needs more than the C library has the name of this system alone.
    other = built(tmp_path, "other", "extern double one(double); double two(void) { return one(2); }", plain)
    wheel = with_metadata(made(tmp_path, tag, [plain, other]), tag)
    assert manylinux.retag(wheel) == wheel and wheel.is_file()


def with_metadata(wheel: Path, tag: str) -> Path:
    """A wheel with the files that say what it is."""
    with zipfile.ZipFile(wheel, "a") as archive:
        info = "pliant-0.1.0.dist-info"
        archive.writestr(f"{info}/METADATA", "Metadata-Version: 2.1\nName: pliant\nVersion: 0.1.0\n")
        archive.writestr(f"{info}/WHEEL", f"Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: false\nTag: cp311-abi3-{tag}\n")
        names = [name for name in archive.namelist() if not name.endswith("RECORD")]
        rows = []
        for name in names:
            digest = base64.urlsafe_b64encode(hashlib.sha256(archive.read(name)).digest()).rstrip(b"=").decode()
            rows.append(f"{name},sha256={digest},{archive.getinfo(name).file_size}")
        archive.writestr(f"{info}/RECORD", "\n".join([*rows, f"{info}/RECORD,,", ""]))
    return wheel
