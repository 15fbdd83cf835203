"""The design studio: change a description in the browser, and see at once what it does.

A reader's way: opened.py, design.py (with field.py and fields.py), results.py, cloud.py, session.py (with worker.py),
saving.py, report.py, tuning.py; none of these knows NiceGUI. Then page.py, and what it puts together.
"""
