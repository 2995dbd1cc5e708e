"""The oracle: tests sppm's rays and images against independent software.

Intersections are compared with Embree and with geometry in f64, images are measured by OpenCV, and Mitsuba 3 renders
the ground truth. The oracle only reads files and runs the command `sppm`; no part of sppm depends on it.
"""
