"""The part of the build that pyproject.toml cannot say: the mark that the modules of the list are typed."""

from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py


class BuildTyped(build_py):
    """Copies the modules, and the mark beside them."""

    def run(self) -> None:
        """Build."""
        super().run()
        (Path(self.build_lib) / "ods" / "py.typed").touch()


setup(cmdclass={"build_py": BuildTyped})
