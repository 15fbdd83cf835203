"""The packing cell at work, on a page: a run goes on in its own process, and another one shows it to whoever looks on.

A reader's way: snapshot.py says what travels between the two. Beside the run stand frames.py and watcher.py, and
link.py, which begins the other process: serving.py, with desk.py, and page.py with its views.
"""
