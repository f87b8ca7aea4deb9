"""The examples do what they say."""

import doctest
import sys
from pathlib import Path

import numpy as np
import pytest

import pliant

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))


def test_the_environment_is_touched_with_the_forces_that_were_asked_for():
    import touch_env

    for goal, force in touch_env.main():
        assert force == pytest.approx(goal, rel=0.05)


def test_the_environment_is_one_of_gymnasiums():
    pytest.importorskip("gymnasium")
    import touch_env
    from gymnasium.utils.env_checker import check_env

    env = touch_env.TouchEnv()
    check_env(env, skip_render_check=True)
    env.close()


def test_a_stiffness_is_estimated_within_its_noise():
    pytest.importorskip("scipy")
    import stiffness_estimation

    true, found = stiffness_estimation.main()
    # Four forces with 1 % of noise each.
    assert found == pytest.approx(true, rel=0.03)


def test_a_sweep_is_drawn(tmp_path):
    pytest.importorskip("matplotlib")
    import sweep_plot

    stiffnesses, largest = sweep_plot.main(tmp_path / "sweep.png")
    assert (np.diff(largest) > 0).all(), "the stiffer, the larger"
    assert (tmp_path / "sweep.png").stat().st_size > 10_000


def test_a_law_written_in_python_conforms_and_stiffens():
    import python_material

    cases, forces = python_material.main()
    assert {case.verdict for case in cases} <= {"passed", "skipped"}
    (shallow, deep), (shallow_too, deep_too) = forces["built in"], forces["stiffening"]
    # Of one stiffness at small strains; deeper the law has become stiffer.
    assert shallow_too == pytest.approx(shallow, rel=0.05) and deep_too > 1.1 * deep


def test_a_law_by_automatic_differentiation_is_the_one_written_by_hand():
    pytest.importorskip("jax")
    import autodiff_material

    cases, difference, forces = autodiff_material.main()
    assert {case.verdict for case in cases} <= {"passed", "skipped"}, cases
    assert difference < 1e-12, "to the rounding of double precision"
    # The stiffness by hand is of differences of the stress: steps differ by what a solve leaves.
    assert forces["differentiated"] == pytest.approx(forces["by hand"], rel=1e-3) and forces["by hand"][1] > 0.1


def test_examples_of_the_documentation_run():
    for module in ("pliant._scene", "pliant.catalogue", "pliant._hyperelastic", "pliant._batch"):
        assert doctest.testmod(sys.modules[module]).failed == 0


def test_the_readme_runs(capsys):
    text = (Path(__file__).resolve().parents[1] / "README.md").read_text()
    code = text.split("```python\n")[1].split("```")[0]
    exec(compile(code, "README.md", "exec"), {})
    force = float(capsys.readouterr().out.split()[-2].rstrip("]"))
    assert force > 0.05 and pliant.__version__
