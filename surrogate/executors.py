"""Who solves the blocks: this process, processes on this machine, or the workers of a Dask scheduler."""

from __future__ import annotations

import logging
import multiprocessing
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any, NoReturn

from ancf.errors import InputError, Message
from surrogate.gate import solver_digest

PATIENCE = "10 s"  # for a scheduler to answer


@contextmanager
def opened(workers: int = 1, scheduler: str | None = None) -> Iterator[Executor | None]:
    """The executor for a number of processes or a scheduler's address; None for this process.

    Raises
    ------
    InputError : the scheduler does not answer, has no workers, or they run other code.
    ModuleNotFoundError : distributed is not installed (extra "cluster").
    """
    if scheduler is not None:
        cluster = Cluster(scheduler)
        try:
            yield cluster
        finally:
            cluster.shutdown()
    elif workers > 1:
        # Spawned and not forked: a fork in a process with threads (those of the linear algebra) may hang.
        spawn = multiprocessing.get_context("spawn")
        pool = ProcessPoolExecutor(workers, mp_context=spawn, initializer=_leave_interrupts_to_the_parent)
        try:
            yield pool
        finally:
            pool.shutdown(cancel_futures=True)
    else:
        yield None


class Cluster(Executor):
    """The workers of a Dask scheduler; a task whose worker dies is given to another one by the scheduler."""

    def __init__(self, address: str) -> None:
        from distributed import Client  # pyright: ignore[reportMissingImports]
        from distributed.comm.addressing import get_address_host_port  # pyright: ignore[reportMissingImports]

        self.address = address
        _hush()
        try:
            get_address_host_port(address)  # a client of no address is left half made, and cries at its end
            self.client: Any = Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            self._refuse(
                "The scheduler does not answer.", f"{type(error).__name__}: {error}",
                "it is not running, or the address or port is another", "start it with `dask scheduler`",
            )  # fmt: skip
        self.inner = self.client.get_executor(pure=False)
        try:
            self._check_workers()
        except BaseException:
            self.shutdown()
            raise

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Give a task to the scheduler."""
        return self.inner.submit(fn, *args, **kwargs)

    def lost(self) -> str:
        """Why nothing can come back any more; empty while a worker is left."""
        try:
            workers = len(self.client.nthreads())
        except (OSError, TimeoutError) as error:
            return f"the scheduler at {self.address} is gone: {type(error).__name__}"
        if self.client.status != "running":
            return f"the scheduler at {self.address} is gone: connection {self.client.status}"
        return "" if workers else f"no worker is left at {self.address}"

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = True) -> None:
        """Let go of the scheduler, which goes on for others."""
        self.client.close()

    def _check_workers(self) -> None:
        try:
            digests = self.client.run(solver_digest)
        except Exception as error:  # what a worker raises comes as its own type
            self._refuse(
                "The workers cannot run this program.", f"{type(error).__name__}: {error}",
                "ancf is not installed there, or in another version",
                "pip install 'ancf[cluster]' on each of them",
            )  # fmt: skip
        if not digests:
            self._refuse(
                "The scheduler has no workers.", "0 workers", "none was started, or none found the scheduler",
                f"start some with `dask worker {self.address}`",
            )  # fmt: skip
        others = sorted(name for name, digest in digests.items() if digest != solver_digest())
        if others:
            self._refuse(
                "Workers run other code than this process.",
                f"digest of ancf/ differs on {', '.join(others)}",
                "another version is installed there", "install the same version on all machines",
            )  # fmt: skip

    def _refuse(self, what: str, value: str, cause: str, advice: str) -> NoReturn:
        raise InputError(Message(what, f"--scheduler {self.address}", value, cause, advice))


def _hush() -> None:
    """Keep Dask's log of lost connections and its tracebacks quiet: `lost` says the same in one line."""
    known = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] == "distributed"]
    for name in (*known, "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL)


def _leave_interrupts_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
