"""Decomposition: a solid that no sweep fits is cut into cells that all sweep and agree.

Place in the flow: between ``cad`` and ``plan``; ``pipeline`` gives it what recognises, plans and cuts as callables.
"""
