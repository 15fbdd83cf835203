"""Page of a packing cell at work: the run goes on in one process, and another one serves its page.

Reading order: snapshot.py defines the messages between the two. In the run's process are watcher.py and link.py, which
starts the other process; in that one are desk.py, and page.py with its views.
"""
