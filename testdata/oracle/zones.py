"""Says of places whether they are inside a polygon or on its edge, by shapely: the oracle of tests/zones/geometry.rs.

A line of standard input is {"polygon": GeoJSON, "places": [[longitude, latitude], ...]}; for each place 1 or 0 is printed.
"""

import json
import sys

import shapely
from shapely.geometry import shape

for line in sys.stdin:
    given = json.loads(line)
    polygon = shape(given["polygon"])
    places = shapely.points(given["places"])
    print("".join("01"[int(inside)] for inside in shapely.intersects(polygon, places)))
