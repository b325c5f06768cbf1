"""The sweep: blocks of a plan go to an executor, come back in any order, and are put together in theirs.

Finished blocks lie in ``blocks/`` in the folder of the data set, so that a sweep that was cut off goes on
where it stopped, and shards from elsewhere can be merged. data.npz and card.json come last, then blocks go.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from itertools import islice
from pathlib import Path
from typing import NoReturn

import numpy as np

from ancf.errors import InputError, Message
from surrogate import npz
from surrogate.blocks import RESULTS, Block, Solved, solve
from surrogate.card import card
from surrogate.dataset import CARD, DATA, STAMP, DataSet, load, read_card, refuse
from surrogate.design import Design, design_from_dict
from surrogate.gate import UNVALIDATED, ask, refuse_outside
from surrogate.plan import Plan
from surrogate.store import Store, compare, read_plan, refuse_shard
from surrogate.whole_file import write_text, writing

LOST = (BrokenExecutor, CancelledError, OSError)  # a worker was killed, a scheduler went away
SILENCE = 10.0  # seconds without an answer after which an executor is asked whether workers are left
IN_FLIGHT = 256  # blocks with the workers at once: enough for a hundred of them, few enough to stop soon

Progress = Callable[[int, int], None]


def make(
    design: Design,
    folder: str | Path,
    executor: Executor | None = None,
    *,
    allow_unvalidated: bool = False,
    progress: Progress | None = None,
) -> DataSet:
    """Solve a design and write its data set, or go on with one that was cut off.

    Parameters
    ----------
    executor : any of concurrent.futures, or of Dask; None solves in this process. The bytes are the same.
    progress : called with the numbers of blocks done and of all

    Raises
    ------
    NotValidated : no valid certificate, or rows outside its domain of validity (exit code 4).
    InputError : the folder holds other data or cannot be written, a worker was lost (exit code 2).
    """
    plan, folder = Plan(design, ask(allow_unvalidated)), Path(folder)
    if not finished(plan, folder, allow_unvalidated):
        sweep(plan, folder, range(plan.blocks), executor, allow_unvalidated, progress)
        assemble(plan, folder, allow_unvalidated)
    return load(folder)


def sweep(
    plan: Plan,
    folder: Path,
    numbers: Iterable[int],
    executor: Executor | None = None,
    allow_unvalidated: bool = False,
    progress: Progress | None = None,
) -> None:
    """Solve those of some blocks that are not on disk yet, and keep each as soon as it is solved.

    Raises as `make`; what the gate refuses leaves no blocks behind, unless there were some before.
    """
    store, numbers = Store(folder, plan), list(numbers)
    new = store.open()
    wanted, damaged = store.unfinished(numbers)
    for reason in damaged:
        print(f"{reason}; it is solved again", file=sys.stderr)
    done = len(numbers) - len(wanted)
    for solved in _solved(map(plan.block, wanted), executor):
        if solved.solver != plan.record["solver"]:
            _refuse_worker(solved, plan)
        if solved.outside and not allow_unvalidated:
            if new:
                store.clear()
            refuse_outside(f"design {plan.design.name}", solved.outside)
        store.write(solved)
        done += 1
        if progress is not None:
            progress(done, len(numbers))


def merge(parts: Sequence[Path], folder: Path, allow_unvalidated: bool = False) -> DataSet:
    """Put the shards in several folders together; they stay as they are.

    Raises
    ------
    OtherPlan : a shard is of another design, code or certificate than the first, or than the present ones.
    InputError : a block is missing or damaged; everything else that could be taken is kept.
    """
    record = read_plan(parts[0])
    design = design_from_dict(record.get("design", {}), str(parts[0]))
    plan = Plan(design, ask(allow_unvalidated))
    if not finished(plan, folder, allow_unvalidated):
        store = Store(folder, plan)
        store.open()
        for part in parts:
            store.take_in(part)
        assemble(plan, folder, allow_unvalidated)
    return load(folder)


def assemble(plan: Plan, folder: Path, allow_unvalidated: bool = False) -> None:
    """Put the blocks together: data.npz, card.json; the blocks are removed. Raises `InputError`."""
    store = Store(folder, plan)
    missing, damaged = store.unfinished(range(plan.blocks))
    if missing:
        shown = ", ".join(map(str, missing[:10])) + (", ..." if len(missing) > 10 else "")
        value = "; ".join(damaged) or f"blocks {shown} of {plan.blocks} are not there"
        refuse_shard(store.blocks, value)
    blocks = [store.read(number) for number in range(plan.blocks)]
    outside = [reason for block in blocks for reason in block.outside]
    if not allow_unvalidated:
        refuse_outside(f"design {plan.design.name}", outside)
    sample = plan.sample
    arrays = {name: np.concatenate([block.arrays[name] for block in blocks]) for name in RESULTS}
    arrays |= {"loads": sample.points, "split": sample.split, "group": sample.group}
    arrays["moments"] = plan.design.first_moments(sample.points)
    content = card(plan, arrays, outside)
    arrays[STAMP] = np.array(content["certificate"])
    with writing(folder):
        npz.write(folder / DATA, arrays)
        write_text(folder / CARD, json.dumps(content, indent=1, allow_nan=False) + "\n")
    store.clear()


def finished(plan: Plan, folder: Path, allow_unvalidated: bool = False) -> bool:
    """Whether the folder holds the whole data set of this plan; raises `OtherPlan` if it holds another."""
    if not (folder / CARD).exists():
        if (folder / DATA).exists() and not Store(folder, plan).begun:
            refuse(folder / DATA, "The folder holds data of unknown origin.", f"there is no {CARD} beside it")
        return False
    stored = read_card(folder)
    compare(folder / CARD, stored["plan"], plan)
    if stored["certificate"] == UNVALIDATED and not allow_unvalidated:
        refuse_outside(f"design {plan.design.name}", stored["reasons"])
    return True


def shard(text: str, blocks: int) -> range:
    """Blocks of the shard ``i/n``, the i-th of n: every n-th one, so that all shards take equally long."""
    first, _, count = text.partition("/")
    if not (first.isdecimal() and count.isdecimal() and 1 <= int(first) <= int(count)):
        raise InputError(
            Message(
                "There is no such shard.", f"--shard {text}", "must be i/n with 1 <= i <= n",
                "shards are counted from 1", "write 1/4 for the first of four",
            )
        )  # fmt: skip
    return range(int(first) - 1, blocks, int(count))


def _solved(blocks: Iterable[Block], executor: Executor | None) -> Iterator[Solved]:
    """Answers in the order in which they come; what is still waiting at an error is left to the executor."""
    if executor is None:
        yield from map(solve, blocks)
        return
    waiting: set[Future[Solved]] = set()
    blocks = iter(blocks)
    try:
        while True:
            waiting |= {executor.submit(solve, block) for block in islice(blocks, IN_FLIGHT - len(waiting))}
            if not waiting:
                return
            done, waiting = wait(waiting, SILENCE, FIRST_COMPLETED)
            for future in sorted(done, key=_failed):  # answers first: none is lost
                yield future.result()
            if not done and (reason := _lost(executor)):
                _refuse_lost(reason)
    except Exception as error:
        if not isinstance(error, LOST) and type(error).__name__ != "KilledWorker":  # of distributed
            raise
        _refuse_lost(_lost(executor) or f"{type(error).__name__}: {error}")


def _failed(future: Future[Solved]) -> bool:
    return future.cancelled() or future.exception() is not None


def _lost(executor: Executor) -> str:
    """What an executor that can tell says about workers that are gone; empty while one is left."""
    tell = getattr(executor, "lost", None)
    return tell() if tell is not None else ""


def _refuse_lost(value: str) -> NoReturn:
    raise InputError(
        Message(
            "The workers were lost.", "executor", value,
            "they were killed, ran out of memory, or their machine went away",
            "run the same command again: finished blocks are kept and nothing is lost",
        )
    )  # fmt: skip


def _refuse_worker(solved: Solved, plan: Plan) -> NoReturn:
    raise InputError(
        Message(
            "A worker runs other code than this process.", f"block {solved.number}",
            f"digest of ancf/ {solved.solver[:12]} there, {plan.record['solver'][:12]} here",
            "another version is installed on the worker's machine",
            "install the same version there; the block was not taken",
        )
    )  # fmt: skip
