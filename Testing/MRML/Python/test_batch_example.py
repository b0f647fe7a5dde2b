"""Examples/batch_reconstruct.py against Slicer's real MRML, without a display."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import slicer_core

import test_innergs


def write_scan(path):
    storage = slicer_core.vtkMRMLVolumeArchetypeStorageNode()
    storage.SetFileName(str(path))
    if not storage.WriteData(test_innergs.add_volume(slicer_core.vtkMRMLScene(), size=(16, 15, 14))):
        raise OSError(path)


class BatchExampleTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.source, self.target = (pathlib.Path(folder.name) / name for name in ("scans", "results"))
        self.source.mkdir()
        self.script = str(pathlib.Path(os.environ["INNERGS_EXAMPLES"]) / "batch_reconstruct.py")

    def run_batch(self, source, target, inside_slicer=False):
        command = [self.script, str(source), str(target), "--preset", "fast"]
        if inside_slicer:  # where there is a slicer module and no slicer_core
            command = ["-c", "import slicer_core, slicer, runpy, sys; sys.modules['slicer_core'] = None; import innergs\n"
                             "sys.argv = sys.argv[1:]; runpy.run_path(sys.argv[0], run_name='__main__')"] + command
        return subprocess.run([sys.executable, *command], capture_output=True, text=True, timeout=1500)

    def test_goes_on_after_a_failure(self):
        for name in ("a.1.nii.gz", "a.2.nii", "b.NRRD"):
            write_scan(self.source / name.lower())
        (self.source / "broken.nii").write_bytes(b"nothing")
        for inside_slicer in (False, True):
            done = self.run_batch(self.source, self.target, inside_slicer)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertEqual(len([line for line in done.stderr.splitlines() if line.startswith("broken.nii: ")]), 1, done.stderr)
            self.assertEqual(done.stdout.count(" dB on held-out slices\n"), 3, done.stdout)
            names = sorted(path.name for path in self.target.iterdir())
            self.assertEqual(names, ["a.1.innergs", "a.1.nii.gz", "a.2.innergs", "a.2.nii.gz", "b.innergs", "b.nii.gz",
                                     "report.csv"])
            self.assertEqual(len((self.target / "report.csv").read_text().splitlines()), 5)
        (self.source / "broken.nii").unlink()
        self.assertEqual(self.run_batch(self.source, self.target).returncode, 0)

    def test_destroys_nothing(self):
        write_scan(self.source / "a.nii.gz")
        before = (self.source / "a.nii.gz").read_bytes()
        link = self.source.parent / "link"
        link.symlink_to(self.source)
        for target in (self.source, link, self.source / ".." / "scans"):
            done = self.run_batch(self.source, target)
            self.assertEqual(done.returncode, 1)
            self.assertIn("same folder", done.stderr)
        self.target.mkdir()
        (self.target / "a.nii.gz").symlink_to(self.source / "a.nii.gz")
        self.assertIn("one of the scans", self.run_batch(self.source, self.target).stderr)
        (self.target / "a.nii.gz").unlink()
        (self.source / "A.nrrd").write_bytes(b"")
        done = self.run_batch(self.source, self.target)
        self.assertEqual(done.returncode, 1)
        self.assertIn("same name", done.stderr)
        self.assertEqual(list(self.target.iterdir()), [])
        self.assertEqual(sorted(path.name for path in self.source.iterdir()), ["A.nrrd", "a.nii.gz"])
        self.assertEqual((self.source / "a.nii.gz").read_bytes(), before)


if __name__ == "__main__":
    unittest.main()
