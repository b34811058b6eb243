"""Worker processes of a series: Ctrl-C and SIGTERM are for their parent, and it alone ends them."""

import signal
from multiprocessing.context import SpawnContext, SpawnProcess


class Worker(SpawnProcess):
    """A process that signals do not end, from its first moment on: a batch system sends them to all."""

    def start(self):
        """Start it. What is blocked here is blocked there, before a line of Python has run."""
        if not hasattr(signal, "pthread_sigmask"):  # Windows
            super().start()
            return
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
        try:
            super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)

    def terminate(self):
        """End it: as SIGTERM does not, the executor would wait for ever for the workers beside one that has died."""
        self.kill()


class Workers(SpawnContext):
    """The way to start them, the same on every system."""

    Process = Worker

    def end(self):
        """End all that are alive."""
        for worker in self.active_children():
            if isinstance(worker, Worker):
                worker.kill()
