"""Small meshes of awkward kinds, made from a seed: (kind, vertices, faces) each, as OBJ
text when they are uploaded, some as GLB. None has more than a few hundred vertices."""

import json
import math
import struct


def sphere(rows, columns, pole=None, height=1.0):
    """Rows at pi i / rows, poles and seam written as modelling programs do: a pole is a
    ring of radius sin(pi), or `pole`."""
    points, faces = [], []
    for i in range(rows + 1):
        radius = math.sin(math.pi * i / rows)
        if pole is not None and i in (0, rows):
            radius = pole
        for j in range(columns + 1):
            turn = 2 * math.pi * j / columns
            points.append((radius * math.cos(turn), height * math.cos(math.pi * i / rows),
                           radius * math.sin(turn)))
    for i in range(rows):
        for j in range(columns):
            a = i * (columns + 1) + j
            b = a + columns + 1
            faces += [(a, b, a + 1), (a + 1, b, b + 1)]
    return points, faces


def grid(columns, rows, height, stretch=1.0, shift=0.0):
    """A terrain over a plane."""
    points = [(stretch * x + shift, y + shift, height(x, y)) for y in range(rows) for x in range(columns)]
    faces = []
    for y in range(rows - 1):
        for x in range(columns - 1):
            a = y * columns + x
            faces += [(a, a + 1, a + columns + 1), (a, a + columns + 1, a + columns)]
    return points, faces


def torus(rings, sides, thick):
    """A torus about y."""
    points, faces = [], []
    for i in range(rings):
        for j in range(sides):
            u, v = 2 * math.pi * i / rings, 2 * math.pi * j / sides
            out = 1 + thick * math.cos(v)
            points.append((out * math.cos(u), thick * math.sin(v), out * math.sin(u)))
            a, b = i * sides + j, ((i + 1) % rings) * sides + j
            c, d = i * sides + (j + 1) % sides, ((i + 1) % rings) * sides + (j + 1) % sides
            faces += [(a, b, d), (a, d, c)]
    return points, faces


def cone(sides, tip, rings=4):
    """A cone from radius 1 to radius `tip`, open at both ends."""
    points, faces = [], []
    for i in range(rings + 1):
        radius = max(1 - i / rings, tip)
        for j in range(sides):
            turn = 2 * math.pi * j / sides
            points.append((radius * math.cos(turn), i / rings, radius * math.sin(turn)))
            if i < rings:
                a, b = i * sides + j, i * sides + (j + 1) % sides
                faces += [(a, b, b + sides), (a, b + sides, a + sides)]
    return points, faces


def star(tips, far):
    """A centre and tips round it, alternately near and far."""
    points = [(0.0, 0.0, 0.0)]
    for i in range(tips):
        radius = far if i % 2 else 1.0
        turn = 2 * math.pi * i / tips
        points.append((radius * math.cos(turn), radius * math.sin(turn), 0.0))
    return points, [(0, 1 + i, 1 + (i + 1) % tips) for i in range(tips)]


def book(pages):
    """Many faces on one edge."""
    points = [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
    points += [(math.cos(2 * math.pi * i / pages), 0.5, math.sin(2 * math.pi * i / pages)) for i in range(pages)]
    return points, [(0, 1, 2 + i) for i in range(pages)]


def soup(chance, count, low=0.0, high=0.0):
    """Faces thrown together on few vertices, whose coordinates have any magnitude."""
    def number():
        return chance.uniform(-1, 1) * 10 ** chance.uniform(low, high)
    points = [(number(), number(), number()) for _ in range(count)]
    faces = [tuple(chance.sample(range(count), 3)) for _ in range(2 * count)]
    return points, faces


def merged(*parts):
    """Several meshes in one file, and a vertex that no face has."""
    points, faces = [(9.0, 9.0, 9.0)], []
    for more, some in parts:
        base = len(points)
        points += more
        faces += [tuple(base + corner for corner in face) for face in some]
    return points, faces


def scaled(mesh, factor):
    """The same, larger or smaller."""
    return [tuple(factor * x for x in point) for point in mesh[0]], mesh[1]


def bumpy(x, y):
    """A height."""
    return 0.6 * math.sin(3 * x) * math.cos(2 * y) + 0.1 * math.sin(17 * x + 3 * y)


def every_mesh(chance):
    """Some thirty, by kind."""
    rough = [chance.random() for _ in range(400)]
    columns = [sum(0.1 ** k for k in range(i)) for i in range(12)]
    wedge = [(columns[i], float(j), 0.0) for i in range(12) for j in range(2)]
    strip = [(2 * i, 2 * i + 2, 2 * i + 3) for i in range(11)] + [(2 * i, 2 * i + 3, 2 * i + 1) for i in range(11)]
    mobius = []
    for i in range(24):
        turn = math.pi * i / 12
        for side in (-0.3, 0.3):
            out = 1 + side * math.cos(turn / 2)
            mobius.append((out * math.cos(turn), out * math.sin(turn), side * math.sin(turn / 2)))
    twisted = []
    for i in range(24):
        a, b = 2 * i, 2 * i + 1
        c, d = (2 * i + 2, 2 * i + 3) if i < 23 else (1, 0)
        twisted += [(a, b, d), (a, d, c)]
    triangle = ([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)], [(0, 1, 2)])
    return {
        "sphere 8x12": sphere(8, 12),
        "sphere 3x6": sphere(3, 6),
        "sphere poles 1e-7": sphere(6, 9, 1e-7),
        "sphere poles 1e-12": sphere(6, 9, 1e-12),
        "sphere poles 1e-15": sphere(6, 9, 1e-15),
        "sphere poles 1e-40": sphere(5, 8, 1e-40),
        "sphere poles exact": sphere(7, 10, 0.0),
        "needle": sphere(6, 8, None, 1000.0),
        "pancake": sphere(6, 8, None, 1e-4),
        "torus": torus(14, 9, 0.4),
        "torus thin": torus(20, 4, 1e-5),
        "cone": cone(9, 0.0),
        "cone cut 1e-16": cone(9, 1e-16),
        "cone cut 1e-3": cone(9, 1e-3),
        "star 1e6": star(24, 1e6),
        "star 10": star(40, 10.0),
        "book": book(60),
        "copies": (triangle[0], triangle[1] * 200),
        "copies thin": ([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, 1e-9, 0.0)], [(0, 1, 2)] * 200),
        "one face": triangle,
        "plane": grid(12, 10, lambda x, y: 0.0),
        "plane moved": grid(12, 10, lambda x, y: 0.0, 1.0, float(1 << 20)),
        "bumpy": grid(18, 18, bumpy),
        "terrain": grid(15, 14, lambda x, y: rough[15 * y + x]),
        "terrain stretched": grid(4, 4, lambda x, y: rough[15 * y + x], 8.0),
        "cliffs": grid(8, 8, lambda x, y: 10 * rough[8 * y + x]),
        "no area": ([(float(i), 0.0, 0.0) for i in range(9)], [(i, i + 1, i + 2) for i in range(7)]),
        "columns": (wedge, strip),
        "moebius": (mobius, twisted),
        "soup": soup(chance, 12),
        "soup of all sizes": soup(chance, 10, -6, 3),
        "parts": merged(triangle, sphere(4, 6), grid(4, 4, bumpy)),
        "tiny": scaled(torus(8, 6, 0.3), 1e-20),
        "huge": scaled(torus(8, 6, 0.3), 1e15),
    }


def obj(mesh, name):
    """The text of a mesh as a file, `name` being in it: another name, other bytes."""
    points, faces = mesh
    lines = [f"# {name}"]
    lines += ["v " + " ".join(repr(float(x)) for x in point) for point in points]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]
    return ("\n".join(lines) + "\n").encode()


# Kinds whose files have weights in them.
MUDDY = ("bumpy", "torus", "parts")


def glb(mesh, name):
    """The same as a GLB, whose vertices have an attribute `_MUD`."""
    points, faces = mesh
    mud = [1 + v % 7 / 2 for v in range(len(points))]
    arrays = [(5126, "VEC3", struct.pack(f"<{3 * len(points)}f", *(x for point in points for x in point))),
              (5126, "SCALAR", struct.pack(f"<{len(mud)}f", *mud)),
              (5125, "SCALAR", struct.pack(f"<{3 * len(faces)}I", *(corner for face in faces for corner in face)))]
    counts = [len(points), len(mud), 3 * len(faces)]
    views, at = [], 0
    for _, _, data in arrays:
        views.append({"buffer": 0, "byteOffset": at, "byteLength": len(data)})
        at += len(data)
    document = {
        "asset": {"version": "2.0", "generator": name}, "buffers": [{"byteLength": at}], "bufferViews": views,
        "accessors": [{"bufferView": i, "componentType": component, "type": shape, "count": counts[i]}
                      for i, (component, shape, _) in enumerate(arrays)],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "_MUD": 1}, "indices": 2}]}],
        "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0,
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    return (struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + at, len(text), 0x4E4F534A) + text
            + struct.pack("<II", at, 0x004E4942) + b"".join(data for _, _, data in arrays))
