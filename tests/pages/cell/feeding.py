"""The page of a packing run without the run: images and snapshots come as often as they do from one."""

FED = """
import signal, threading
from collections import Counter
from multiprocessing import Pipe
from layflat.pages.cell.link import serve_run
from layflat.pages.cell.snapshot import MAX_PICK_ROWS, PickFigures, RunRequests, RunSnapshot, RunStage, RunSubject
from layflat.pages.server.place import Endpoint

COLUMNS = ("pick", "fruit", "result", "time", "air", "remark")
mine, its = Pipe()
over = threading.Event()
signal.signal(signal.SIGINT, lambda *_: over.set())

def feed():
    print(mine.recv()[1], flush=True)
    count = 0
    while not over.wait(0.125):
        count += 1
        mine.send(("overview", bytes(40_000)))
        if count % 3 == 0:
            mine.send(("camera", bytes(90_000)))
        rows = tuple(tuple(f"{name} {count - row}" for name in COLUMNS) for row in range(MAX_PICK_ROWS))
        figures = PickFigures(Counter(correct=count, dropped=count // 9), air=0.5 * count, time=8.0 * count)
        mine.send(("snapshot", RunSnapshot(
            RunStage.PACKS, delivery=1 + count // 50, time=0.125 * count, pace=1.0, fruit=f"tomato {count}",
            doing="The arm lifts the fruit.", fruit_counts="apple 2, tomato 5", figures=figures, rows=rows,
            remarks=tuple(f"remark {count - row}" for row in range(9)),
        )))
    mine.close()

threading.Thread(target=feed).start()
serve_run(RunSubject("cell", "arm", 1, 10**6, COLUMNS), Endpoint(port=0), its, RunRequests.shared())
raise SystemExit(0)
"""
"""In place of a command that serves a page."""
