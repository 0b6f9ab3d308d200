#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the program links, and what it loads: start-up stays cheap, no code comes from the current
folder, standard output belongs to panelcal.

    linkage_test.py PANELCAL MODULES SOURCE [hardened]

Counts libraries instead of measuring time, so that it says the same on any machine.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

# libc, libm, libgcc_s, libstdc++, libfmt, libmd, libapriltag, the loader and the kernel's own; a few
# to spare. It was 167 with OpenCV's picture decoders.
MAX_LIBRARIES = 12
# Each costs every command what only some commands use; the modules bring them.
FORBIDDEN = ("aravis", "blas", "brotli", "ceres", "cholmod", "cpp-httplib", "crypto", "gdal", "gdcm", "gflags", "glib",
             "glog", "gobject", "jpeg", "lapack", "opencv", "png", "spqr", "sqlite", "ssl", "tbb", "tiff")


def output_of(*command, **options):
    return subprocess.run(command, check=True, capture_output=True, text=True, **options).stdout


def dynamic(file):
    """[(tag, value)] of readelf -d."""
    rows = re.findall(r"^ 0x[0-9a-f]+ \((\w+)\)\s+(.*)$", output_of("readelf", "-dW", file), re.M)
    assert rows, file
    return rows


def program_needs_few_libraries(panelcal):
    loaded = [line.split()[0] for line in output_of("ldd", panelcal).splitlines()]
    for library in loaded:
        name = Path(library).name
        assert not any(name.startswith("lib" + word) for word in FORBIDDEN), f"start-up loads {name}"
    assert len(loaded) <= MAX_LIBRARIES, loaded


def run_path_is_absolute(file):
    for tag, value in dynamic(file):
        if tag not in ("RPATH", "RUNPATH"):
            continue
        for entry in re.search(r"\[(.*)\]", value).group(1).split(":"):
            # The loader takes an empty entry for the current folder.
            assert entry.startswith(("/", "$ORIGIN")), f"{file}: run path entry \"{entry}\""


def is_hardened(file, is_program):
    assert "Type:                              DYN" in output_of("readelf", "-hW", file), file
    assert "GNU_RELRO" in output_of("readelf", "-lW", file), f"{file}: no RELRO"
    flags = " ".join(value for tag, value in dynamic(file) if tag in ("FLAGS", "FLAGS_1"))
    assert "NOW" in flags, f"{file}: lazy binding"
    if is_program:
        assert "PIE" in flags, f"{file}: not position-independent"
        symbols = output_of("readelf", "--dyn-syms", "-W", file)
        assert "__stack_chk_fail" in symbols, f"{file}: no stack protector"
        assert re.search(r"__\w+_chk\b", symbols), f"{file}: no checked functions"


def locate(panelcal, source, cwd, **environment):
    demo = Path(source) / "datasets/demo"
    return subprocess.run([panelcal, "locate", str(demo / "images/0000.png"), "--tool", "1", "-m",
                           str(demo / "machine.toml")], cwd=cwd, capture_output=True, text=True,
                          env={**os.environ, **environment}, timeout=60)


def current_folder_lends_no_code(panelcal, modules, source):
    """A library of the right name in the job's folder is not even looked at."""
    with tempfile.TemporaryDirectory() as folder:
        for file in Path(modules).glob("*.so"):
            (Path(folder) / file.name).write_text("no library")
        done = locate(panelcal, source, folder, LD_LIBRARY_PATH=folder)
        assert done.returncode == 0, done.stderr


def broken_module_is_named(panelcal, modules, source):
    """A damaged installation: exit 3, and the file that is to blame."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        beside = os.path.relpath(Path(modules).resolve(), Path(panelcal).resolve().parent)
        (root / "bin").mkdir()
        shutil.copy(panelcal, root / "bin/panelcal")
        broken = Path(os.path.normpath(root / "bin" / beside)) / "libpanelcal_vision.so"
        assert root in broken.parents, broken
        broken.parent.mkdir(parents=True)
        broken.write_text("no library")
        done = locate(str(root / "bin/panelcal"), source, folder)
        assert done.returncode == 3, done
        assert str(broken) in done.stderr and done.stdout == "", done
        assert output_of(str(root / "bin/panelcal"), "--version").startswith("panelcal")


def standard_output_is_ours(panelcal, source):
    plain = locate(panelcal, source, source)
    assert plain.returncode == 0 and plain.stdout, plain.stderr
    for level in ("DEBUG", "VERBOSE"):
        talkative = locate(panelcal, source, source, OPENCV_LOG_LEVEL=level)
        assert talkative.stdout == plain.stdout, talkative.stdout
        assert talkative.stderr == plain.stderr, talkative.stderr


def main():
    panelcal, modules, source, *hardened = sys.argv[1:]
    files = sorted(Path(modules).glob("libpanelcal_*.so"))
    assert len(files) >= 4, files
    for file in [panelcal, *files]:
        run_path_is_absolute(file)
    if hardened:
        program_needs_few_libraries(panelcal)
        for file in [panelcal, *files]:
            is_hardened(file, file == panelcal)
    current_folder_lends_no_code(panelcal, modules, source)
    broken_module_is_named(panelcal, modules, source)
    standard_output_is_ours(panelcal, source)


if __name__ == "__main__":
    main()
