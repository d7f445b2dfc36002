#!/usr/bin/env python3
"""The report on small meshes: its tables are whole and agree with each other, and the
text's figures are those of the tables.

    report_test.py PAPER_REPORT
"""

import csv
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = sys.argv.pop()
WRITER = pathlib.Path(__file__).with_name("write_report.py")


def run(*command):
    """Runs a program that must succeed."""
    subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)


class Report(unittest.TestCase):
    """One run of the program, many looks at it."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        run(PROGRAM, "--small", cls.folder)
        cls.tables = {}
        for file in cls.folder.glob("*.csv"):
            with open(file, newline="", encoding="utf-8") as lines:
                cls.tables[file.stem] = list(csv.DictReader(lines))

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def write(self):
        """The text, made anew from the tables as they are on disk."""
        run(sys.executable, WRITER, self.folder)
        return (self.folder / "report.md").read_text(encoding="utf-8")

    def test_every_table_has_whole_rows(self):
        self.assertLessEqual(
            {"fig5", "holes", "fig8", "novotni", "table", "exact", "timing"}, self.tables.keys()
        )
        for name, rows in self.tables.items():
            self.assertTrue(rows, name)
            for row in rows:
                self.assertNotIn(None, row, name)  # more cells than columns
                self.assertNotIn(None, row.values(), name)  # fewer
                self.assertNotIn("nan", row.values(), name)

    def test_every_method_is_on_every_mesh(self):
        rows = self.tables["table"]
        meshes = {row["mesh"] for row in rows}
        methods = {row["method"] for row in rows}
        self.assertGreaterEqual(len(meshes), 8)
        self.assertLessEqual(
            {"wavefront", "novotni", "fast_marching", "dijkstra", "steiner", "exact", "chen_han"},
            methods,
        )
        self.assertEqual(
            sorted((row["mesh"], row["method"]) for row in rows),
            sorted((mesh, method) for mesh in meshes for method in methods),
        )

    def test_figures_of_a_row_agree_with_each_other(self):
        for row in self.tables["table"]:
            value = {key: float(row[key]) for key in row if key not in ("mesh", "title", "method")}
            self.assertLessEqual(value["mean_error"], value["rms_error"] * (1 + 1e-9))
            self.assertLessEqual(value["rms_error"], value["max_error"] * (1 + 1e-9))
            self.assertLessEqual(value["p999_error"], value["max_error"])
            self.assertEqual(value["unreached"], 0, row)
            self.assertGreaterEqual(value["peak_bytes"], 8 * value["vertices"])
            self.assertGreater(value["ms"], 0)
            self.assertGreater(value["y"], 0)
            if row["method"] == "dijkstra":
                self.assertEqual(value["share_below"], 0)  # along edges nothing is too short
                self.assertGreater(value["mean_error"], 0.01)
            if row["method"] in ("exact", "chen_han"):
                self.assertLess(value["max_error"], 1e-9, row)

    def test_exact_is_exact_on_the_planes(self):
        rows = self.tables["exact"]
        self.assertGreaterEqual(len(rows), 4)
        for row in rows:
            self.assertLess(float(row["max_error"]), 1e-9, row)
            self.assertEqual(row["unreached"], "0", row)

    def test_figures_are_the_papers(self):
        for row in self.tables["fig5"]:
            if row["method"] == "wavefront":
                self.assertLess(float(row["max_error"]), 1e-13)
                self.assertLess(float(row["mean_square_error"]), 1e-28)
        passes = {
            row["figure"]: row["passes"]
            for row in self.tables["holes"]
            if row["method"] == "wavefront" and row["diagonals"] == "rising"
        }
        self.assertEqual((passes["fig7a"], passes["fig7b"]), ("below", "above"))
        for row in self.tables["holes"]:
            # No way among the holes is shorter than the shortest.
            self.assertGreater(float(row["path_error"]), -1e-9, row)

    def test_the_text_takes_its_figures_from_the_tables(self):
        before = self.write()
        for name, column in (
            ("fig5", "max_relative_error"),
            ("holes", "path_error"),
            ("fig8", "mean_error"),
            ("novotni", "ours_mean"),
            ("table", "max_error"),
            ("exact", "max_error"),
            ("timing", "mean_error"),
        ):
            file = self.folder / f"{name}.csv"
            original = file.read_text(encoding="utf-8")
            columns, *rows = list(csv.reader(original.splitlines()))
            rows[0][columns.index(column)] = "0.987654321"
            with open(file, "w", newline="", encoding="utf-8") as out:
                csv.writer(out).writerows([columns, *rows])
            after = self.write()
            file.write_text(original, encoding="utf-8")
            self.assertEqual(after.count("99 %"), before.count("99 %") + 1, name)
        self.assertTrue(self.write() == before)


if __name__ == "__main__":
    unittest.main()
