"""The oracle: what other people's code says of sppm's rays and images.

Embree and plain f64 geometry judge its intersections, OpenCV measures its images, and Mitsuba 3 renders the truth that
they are held against. It reads files and runs the command `sppm`; nothing of sppm imports it.
"""
