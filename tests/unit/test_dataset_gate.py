"""The gate of data sets: no data without a valid certificate, none outside its domain, one way around it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import ancf
from ancf.cli import main
from ancf.scene_file import read_tables
from surrogate import gate, npz
from surrogate.blocks import solve
from surrogate.dataset import load
from surrogate.design import design_from_dict
from surrogate.gate import UNVALIDATED, Gate, admit, ask, refuse_outside
from surrogate.plan import Plan
from surrogate.store import OtherPlan
from surrogate.sweep import make, sweep
from tests.certificates import LEFT_OUT, passing_run, roots_in
from tests.datasets import ID, VOUCHED, certificate, small, stale, tables, valid
from tests.regimes import REGIME
from validation.certificate import (
    SHIPPED,
    NotValidated,
    Verification,
    build,
    load as load_certificate,
    verify,
    write,
)
from validation.digests import PACKAGE

DESIGNS = Path(__file__).parents[2] / "examples" / "designs"


def parts(error):
    message = error.value.message
    assert all((message.what, message.where, message.value, message.cause, message.advice))
    return message


def test_the_gate_believes_the_shipped_certificate_if_it_holds():
    """Whichever is true of the present code: it may be stale between two releases."""
    found = verify()
    if found.valid:
        assert ask().id == found.certificate.id and ask().certificate.domain == found.certificate.domain
        assert ask(allow_unvalidated=True).id == found.certificate.id  # nothing to be allowed
    else:
        with pytest.raises(NotValidated) as refused:
            ask()
        assert found.reasons[0] in parts(refused).value
        assert ask(allow_unvalidated=True) == Gate(None, tuple(found.reasons))


@pytest.mark.parametrize(
    ("reasons", "there"),
    [
        (["it cannot be read: No such file or directory"], False),  # missing
        (["ancf/energy.py changed", "case HX-3333-24 changed"], True),  # stale
        (["case HX-3333-24 is FAIL"], True),  # failed
        (["it is of a quick run, not of a full one"], True),
    ],
)
def test_without_a_valid_certificate_there_are_no_data(tmp_path, monkeypatch, capsys, reasons, there):
    found = Verification(Path("certificate.json"), certificate() if there else None, reasons)
    monkeypatch.setattr(gate, "verify", lambda: found)
    out = tmp_path / "data"
    assert main(["dataset", "--preset", "paper", "--out", str(out)]) == 4
    told = capsys.readouterr()
    assert told.out == "" and not out.exists()
    lines = told.err.splitlines()
    assert [line.split(":")[0].strip() for line in lines[1:]] == ["where", "value", "cause", "try"]
    assert "certificate.json" in lines[1] and all(reason in lines[2] for reason in reasons)
    assert "--allow-unvalidated" in lines[4]


def test_the_way_around_is_stamped_everywhere(tmp_path, monkeypatch):
    monkeypatch.setattr(gate, "verify", stale)
    found = make(small(count=10), tmp_path, allow_unvalidated=True)
    assert not found.validated
    assert found.card["certificate"] == UNVALIDATED == str(npz.read(tmp_path / "data.npz")["certificate"])
    assert found.card["reasons"] == ["ancf/energy.py changed"]
    with pytest.raises(NotValidated):  # finished or not
        make(small(count=10), tmp_path)


def test_data_inside_the_domain_carry_the_id(tmp_path, monkeypatch):
    monkeypatch.setattr(gate, "verify", valid())
    found = make(small(), tmp_path)
    assert found.validated and found.card["certificate"] == ID and found.card["reasons"] == []
    assert str(npz.read(tmp_path / "data.npz")["certificate"]) == ID
    # To allow what is not needed changes nothing, not even a byte.
    again = tmp_path / "again"
    make(small(), again, allow_unvalidated=True)
    for name in ("data.npz", "card.json"):
        assert (tmp_path / name).read_bytes() == (again / name).read_bytes()


@pytest.mark.parametrize(
    ("case", "words"),
    [
        ({"loads": ["bending"]}, "no case that passed has 3333, enhanced, saint-venant-kirchhoff, torsion"),
        ({"elements": 8}, "6 elements are fewer than 8"),
        ({"turn": 0.6}, "turn [rad]"),
        ({"section": "annulus"}, "section circle is not among annulus"),
        ({"strain": 0.01}, "largest strain"),  # known from the solution only
    ],
)
def test_samples_outside_the_domain_are_refused_by_name(tmp_path, monkeypatch, case, words):
    monkeypatch.setattr(gate, "verify", valid({**VOUCHED, **case}))
    with pytest.raises(NotValidated) as refused:
        make(small(), tmp_path)
    message = parts(refused)
    assert words in message.value and message.value.startswith("row ")
    assert message.where == "design small"
    assert not list(tmp_path.iterdir())  # the next design finds an empty folder
    found = make(small(), tmp_path, allow_unvalidated=True)
    assert found.card["certificate"] == UNVALIDATED and words in found.card["reasons"][0]
    with pytest.raises(NotValidated, match="row "):  # the finished data without the permission
        make(small(), tmp_path)


def test_one_sample_outside_is_enough(tmp_path, monkeypatch):
    """The largest row of 300 is just beyond the hardest case, and the message names it."""
    plan = Plan(small(), Gate(None))
    sizes = np.linalg.norm(plan.sample.points, axis=1)
    hardest = int(np.argmax(sizes))
    EI_L = 1.0e6 * np.pi * 0.01**4 / 4.0 / 0.4
    between = (np.sort(sizes)[-1] + np.sort(sizes)[-2]) / 2 / EI_L / 1.01  # 1.01: slack of the domain
    monkeypatch.setattr(gate, "verify", valid({**VOUCHED, "turn": float(between)}))
    with pytest.raises(NotValidated) as refused:
        make(small(), tmp_path)
    assert parts(refused).value.startswith(f"row {hardest}: ") and "; row" not in parts(refused).value


def test_every_row_is_judged_and_not_the_hardest_alone():
    """Bending alone was tried up to 1 rad, with torsion to 0.5: the middle row is softer than the first."""
    EI_L = 1.0e6 * np.pi * 0.01**4 / 4.0 / 0.4
    bent, twisted = {**VOUCHED, "loads": ["bending"]}, {**VOUCHED, "turn": 0.5}
    batch = ancf.solve_batch(small().scene, EI_L * np.array([[0, 0.9, 0], [0.6, 0, 0.1], [0.3, 0, 0.1]]))
    assert list(Gate(certificate(bent, twisted)).outside(batch)) == [1]


def test_the_hardest_torsion_is_judged_solved_though_a_moment_across_is_larger():
    """Strain of 0.9 E I/L across: 0.9 R/L = 0.0225; of 0.88 along, shear doubled: 1.3 * 0.88 R/L = 0.0286."""
    EI_L = 1.0e6 * np.pi * 0.01**4 / 4.0 / 0.4
    batch = ancf.solve_batch(small().scene, EI_L * np.array([[0, 0.9, 0], [0.88, 0, 0.01], [0.1, 0, 0.1]]))
    found = Gate(certificate({**VOUCHED, "strain": 0.025})).outside(batch)
    assert list(found) == [1] and "largest strain 0.028" in found[1][0]


def test_blocks_that_were_allowed_are_not_taken_without_the_permission(tmp_path, monkeypatch):
    monkeypatch.setattr(gate, "verify", valid({**VOUCHED, "turn": 0.6}))
    plan = Plan(small(), ask())
    sweep(plan, tmp_path, [0], allow_unvalidated=True)
    with pytest.raises(NotValidated):
        make(small(), tmp_path)
    assert (tmp_path / "blocks" / "000000.npz").exists()  # what was there before stays
    assert make(small(), tmp_path, allow_unvalidated=True).card["certificate"] == UNVALIDATED


def test_rows_under_other_loads_are_judged_solved():
    data = tables(
        count=20, vary=[{"load": "force", "component": axis, "range": [-0.01, 0.01]} for axis in "yz"]
    )
    del data["moment"]
    data["force"] = [{"value": [0, 0, 0], "frame": "body"}]
    design = design_from_dict(data)
    force = {**VOUCHED, "loads": ["force"], "moment": "none"}
    assert solve(Plan(design, Gate(certificate(force))).block(0)).outside == []
    # The bending moment at the base, which only the solution knows: all rows above half of the largest.
    found = solve(Plan(design, Gate(certificate({**force, "turn": 0.1}))).block(0)).outside
    assert 0 < len(found) < 20 and all("turn [rad]" in reason for reason in found)


def test_a_failed_row_says_nothing_and_stays(monkeypatch):
    data = tables(count=6, split="random", vary=[{"load": "force", "component": "x", "range": [-1e5, 1e5]}])
    del data["moment"]
    data["force"], data["solver"] = [{"value": [0, 0, 0], "frame": "body"}], {"max_steps": 3}
    solved = solve(Plan(design_from_dict(data), Gate(certificate())).block(0))
    failed = np.flatnonzero(solved.arrays["status"] != "converged")
    assert len(failed) and not any(
        reason.startswith(f"row {row}:") for row in failed for reason in solved.outside
    )


def test_other_effects_are_never_taken_for_moments_alone():
    """Gravity beside the moments: curvature must come from the solution, or a stub would let it pass."""
    for extra in (
        {"gravity": {"acceleration": [0, 0, -9.81]}},
        {"line_load": [{"value": [0, 1e-3, 0]}]},
        {"force": [{"value": [0, 1e-3, 0]}]},
        {"tendon": [{"tension": 0.1, "path": [[0, 0.005, 0], [1, 0.005, 0]]}]},
    ):
        scene = ancf.scene_from_dict({k: v for k, v in {**tables(), **extra}.items() if k != "design"})
        assert not gate._moments_only(scene)
    assert gate._moments_only(small().scene)


def test_data_are_admitted_by_the_certificate_that_made_them(monkeypatch):
    monkeypatch.setattr(gate, "verify", valid())
    assert admit(ID, "data") == admit(ID, "data", allow_unvalidated=True) == ID
    for stamp in (UNVALIDATED, "d" * 64):
        with pytest.raises(NotValidated) as refused:
            admit(stamp, "data")
        assert parts(refused).value == f"stamped {stamp}, the certificate of this code is {ID}"
        assert admit(stamp, "data", allow_unvalidated=True) == UNVALIDATED
    monkeypatch.setattr(gate, "verify", stale)
    with pytest.raises(NotValidated, match="changed"):
        admit(ID, "data")
    assert admit(ID, "data", True) == admit(UNVALIDATED, "data", True) == UNVALIDATED


def test_the_whole_way_from_a_certificate_to_data(tmp_path):
    """A run that passed in a tree of its own opens the gate there; one byte of the solver closes it."""
    for name in ("ancf", "reference", "validation", "surrogate"):
        shutil.copytree(PACKAGE.parent / name, tmp_path / name, ignore=LEFT_OUT)
    run = passing_run(roots_in(tmp_path))
    run.regimes = {case: [{**REGIME, **VOUCHED}] for case in run.regimes}
    statement = build(run)
    write(statement, tmp_path / "validation" / "certificate.json")
    path = tmp_path / "design.json"
    path.write_text(json.dumps(tables(count=10)))
    code = (  # without numba, whose kernels would be compiled anew in another folder
        "import json, sys; sys.modules['numba'] = None\n"
        "from surrogate.design import design_from_dict; from surrogate.sweep import make, sweep\n"
        "from validation.certificate import NotValidated\n"
        "try: print(make(design_from_dict(json.load(open('design.json'))), 'data').card['certificate'])\n"
        "except NotValidated as error: print(error)"
    )
    command = [sys.executable, "-c", code]
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment)
    assert done.stdout == f"{statement['id']}\n", done.stderr
    with (tmp_path / "ancf" / "units.py").open("a") as file:
        file.write("\n")
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment)
    assert (
        done.stdout.startswith("There is no valid certificate for this code")
        and "ancf/units.py changed" in done.stdout
    )


@pytest.mark.parametrize("name", sorted(path.stem for path in DESIGNS.glob("*.toml")))
def test_examples_lie_in_the_domain_of_the_shipped_certificate(name):
    """Whether it holds for the present code or not: the corners of the box, its hardest points."""
    data = read_tables(DESIGNS / f"{name}.toml")
    corners = [{**variable, "steps": 2} for variable in data["design"]["vary"]]
    data["design"] = {"sampling": "grid", "vary": corners}
    plan = Plan(design_from_dict(data), Gate(load_certificate(SHIPPED)))
    assert solve(plan.block(0)).outside == []


def test_refusal_of_nothing():
    refuse_outside("nowhere", [])


def test_data_of_another_certificate_are_not_gone_on_with(tmp_path, monkeypatch):
    monkeypatch.setattr(gate, "verify", valid())
    make(small(), tmp_path)
    other = certificate()
    other.statement["id"] = "d" * 64  # type: ignore[index]
    monkeypatch.setattr(gate, "verify", lambda: Verification(Path("certificate.json"), other))
    with pytest.raises(OtherPlan) as refused:
        make(small(), tmp_path)
    assert parts(refused).value == f"the certificate differs: {ID} there, {'d' * 64} here"
    assert load(tmp_path).card["certificate"] == ID


def test_a_stamp_cannot_be_edited_away(tmp_path, monkeypatch):
    monkeypatch.setattr(gate, "verify", stale)
    make(small(count=10), tmp_path, allow_unvalidated=True)
    card = json.loads((tmp_path / "card.json").read_text())
    card["certificate"] = ID
    (tmp_path / "card.json").write_text(json.dumps(card))
    with pytest.raises(ancf.InputError, match="stamped UNVALIDATED"):
        load(tmp_path)
