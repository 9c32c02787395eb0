"""What is known of a mesh or a part, for people: pages for browsers, cards for notebooks.

::

    write_report                                     the page about a mesh               meshes
    write_refusal                                    the page about a refused part       refused
    mesh_summary_html, part_card, sweep_card, report_card    in notebooks                cards
"""

from .cards import mesh_summary_html, part_card, report_card, sweep_card
from .meshes import write_report
from .refused import write_refusal

__all__ = ["mesh_summary_html", "part_card", "report_card", "sweep_card", "write_refusal", "write_report"]
