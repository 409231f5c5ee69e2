"""Worlds of known truth that draw detections alone: how well the tracker does on others' data.

A world is a function of a seed and of the rivals to compare with; it gives figures.
"""
