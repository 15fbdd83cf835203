"""Design studio: page on which a person changes a description and sees the results at once.

Reading order: design.py (with field.py), results.py, cloud.py, session.py (with worker.py), saving.py, report.py,
tuning.py; none of these imports NiceGUI. Then page.py and its views.
"""
