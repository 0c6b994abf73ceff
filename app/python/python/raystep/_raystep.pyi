import os
from typing import final

import numpy as np
from numpy.typing import NDArray

__version__: str

class SceneError(Exception): ...
class OptionError(ValueError): ...
class DeviceError(Exception): ...

@final
class Scene:
    name: str
    triangles: int
    device: str
    bounds: tuple[list[float], list[float]] | None
    @staticmethod
    def read(path: str | os.PathLike[str], device: str) -> Scene: ...
    @staticmethod
    def of_triangles(corners: NDArray[np.float32], device: str) -> Scene: ...
    def cast(
        self,
        origins: NDArray[np.float32],
        directions: NDArray[np.float32],
        t_min: NDArray[np.float32],
        t_max: NDArray[np.float32],
        any_hit: bool,
    ) -> NDArray[np.uint32]: ...

def main(arguments: list[str]) -> int: ...
