//! A scene on a device, and rays through it.

use std::collections::BTreeMap;
use std::ops::DerefMut as _;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::prelude::*;
use raystep_kernels::options::folder::Folder;
use raystep_kernels::programs::own;
use raystep_kernels::{AllHits, CastHit, Caster, Options, Ray, RenderError};
use raystep_lab::Machine;
use raystep_scenes as scenes;

use crate::border::{detached, expect_unforked};
use crate::device::choose;
use crate::error::{OptionError, SceneError, of_run};

/// Words of a [`CastHit`]: t, u, v, triangle, material.
const HIT_WORDS: usize = size_of::<CastHit>() / size_of::<u32>();

/// Rays that are made on all cores.
const MANY: usize = 1 << 14;

/// A scene and its structures on a device; those of a kind of ray are built at its first cast.
#[pyclass(frozen, module = "raystep._raystep")]
pub(crate) struct Scene {
    pub(crate) scene: Arc<scenes::Scene>,
    pub(crate) machine: Machine,
    files: Vec<PathBuf>,
    /// A user's program, which reads the scene if it reads one.
    pub(crate) folder: Option<Arc<Folder>>,
    /// For the closest hit, for any, and for all.
    casters: [Mutex<Option<Caster>>; 3],
}

#[pymethods]
impl Scene {
    /// Reads a scene's file, or one that has a name.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf, device: &str, adapter: Option<&str>) -> PyResult<Self> {
        let (scene, files) = detached(py, || raystep_app::read_scene(&path).map_err(SceneError::new_err))?;
        Self::new(py, scene, files, device, adapter)
    }

    /// Takes triangles: N×3×3 corners.
    #[staticmethod]
    fn of_triangles(
        py: Python<'_>,
        corners: PyReadonlyArray3<'_, f64>,
        device: &str,
        adapter: Option<&str>,
    ) -> PyResult<Self> {
        let [_, 3, 3] = *corners.shape() else {
            return Err(OptionError::new_err("triangles: expected an array of shape (N, 3, 3)"));
        };
        let values = corners.as_slice().map_err(|_| OptionError::new_err("triangles: expected a contiguous array"))?;
        let (corners, _) = values.as_chunks::<3>();
        let (triangles, _) = corners.as_chunks::<3>();
        let scene = scenes::Scene::from_triangles_f64(triangles)
            .ok_or_else(|| SceneError::new_err("triangles: a coordinate is not finite in 32 bits"))?;
        Self::new(py, scene, Vec::new(), device, adapter)
    }

    /// Reads a user's program, whose streams begin with these npy files, by their names.
    #[staticmethod]
    fn read_program(
        py: Python<'_>,
        path: PathBuf,
        starts: BTreeMap<String, Vec<u8>>,
        device: &str,
        adapter: Option<&str>,
    ) -> PyResult<Self> {
        let (folder, scene, files) = detached(py, || {
            let (folder, scene, files) = raystep_app::read_program(&path).map_err(SceneError::new_err)?;
            let folder = Arc::new(folder.starting_with(starts));
            own::read(&folder).map_err(|mistake| SceneError::new_err(mistake.to_string()))?;
            Ok::<_, PyErr>((folder, scene, files))
        })?;
        // On the CPU, kernels are interpreted: a GPU in software is faster.
        let of = match device {
            "auto" => Self::new(py, scene.clone(), files.clone(), "gpu", adapter)
                .or_else(|_| Self::new(py, scene, files, device, adapter)),
            device => Self::new(py, scene, files, device, adapter),
        };
        Ok(Self { folder: Some(folder), ..of? })
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.scene.name
    }

    /// The files that it was read from, its own first; none for triangles.
    #[getter]
    fn files(&self) -> Vec<PathBuf> {
        self.files.clone()
    }

    /// The triangles as a GLB file.
    fn glb<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes =
            detached(py, || scenes::write_glb(&self.scene).map_err(|error| SceneError::new_err(error.to_string())))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Its triangles.
    #[getter]
    fn triangles(&self) -> usize {
        self.scene.triangles.len()
    }

    /// The name of its device.
    #[getter]
    fn device(&self) -> String {
        self.machine.name()
    }

    /// What was noticed when it was read.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.scene.notes.iter().map(|note| note.0.to_string()).collect()
    }

    /// The corners of its box, in the coordinates of its file; `None` without triangles.
    #[getter]
    fn bounds(&self) -> Option<([f64; 3], [f64; 3])> {
        self.scene.bounds_in_file().map(|[min, max]| (min.to_array(), max.to_array()))
    }

    /// What is subtracted from coordinates before they are rounded to f32.
    #[getter]
    fn offset(&self) -> [f64; 3] {
        self.scene.offset.to_array()
    }

    /// The hits of rays, five words each: see `HIT` in `_scene.py`. With `which` 0 the closest of each ray, with 1 any; with 2
    /// all, and the rays' numbers.
    fn cast<'py>(
        &self,
        py: Python<'py>,
        origins: PyReadonlyArray2<'py, f32>,
        directions: PyReadonlyArray2<'py, f32>,
        t_min: PyReadonlyArray1<'py, f32>,
        t_max: PyReadonlyArray1<'py, f32>,
        which: usize,
    ) -> PyResult<(Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<u64>>)> {
        expect_unforked()?;
        let contiguous = |_| OptionError::new_err("expected contiguous arrays");
        let (origins, directions) =
            (origins.as_slice().map_err(contiguous)?, directions.as_slice().map_err(contiguous)?);
        let (t_min, t_max) = (t_min.as_slice().map_err(contiguous)?, t_max.as_slice().map_err(contiguous)?);
        let (origins, _) = origins.as_chunks::<3>();
        let (directions, _) = directions.as_chunks::<3>();
        // One value for all rays, or one for each.
        let of = |all: &[f32], i: usize| if all.len() == 1 { all[0] } else { all[i] };
        let count = origins.len();
        if directions.len() != count || [t_min.len(), t_max.len()].iter().any(|&n| n != 1 && n != count) {
            return Err(OptionError::new_err("origins, directions, t_min and t_max differ in length"));
        }
        let ray = |i: usize| Ray::new(origins[i], directions[i]).between(of(t_min, i), of(t_max, i));
        // Waking other threads takes longer than making a few rays.
        let rays: Vec<Ray> = match count {
            ..MANY => (0..count).map(ray).collect(),
            _ => (0..count).into_par_iter().map(ray).collect(),
        };
        let AllHits { rays, hits } = detached(py, || self.hits(&rays, which).map_err(|error| of_run(&error)))?;
        let count = hits.len();
        let words: Vec<u32> = bytemuck::allocation::cast_slice_box(hits.into_boxed_slice()).into_vec();
        debug_assert_eq!(words.len(), HIT_WORDS * count);
        Ok((PyArray1::from_vec(py, words), PyArray1::from_vec(py, rays)))
    }
}

impl Scene {
    fn new(
        py: Python<'_>,
        scene: scenes::Scene,
        files: Vec<PathBuf>,
        device: &str,
        adapter: Option<&str>,
    ) -> PyResult<Self> {
        let machine = detached(py, || choose(device, adapter))?;
        Ok(Self { scene: Arc::new(scene), machine, files, folder: None, casters: Default::default() })
    }

    /// Casts, one call after the other.
    fn hits(&self, rays: &[Ray], which: usize) -> Result<AllHits, RenderError> {
        let (any_hit, all_hits) = (which == 1, which == 2);
        let mut kept = self.casters[which.min(2)].lock().unwrap_or_else(PoisonError::into_inner);
        pollster::block_on(async {
            let caster = match kept.deref_mut() {
                Some(caster) => caster,
                empty => {
                    let options = Options { any_hit, all_hits, ..Caster::options() };
                    empty.insert(Caster::new(self.scene.clone(), &options, &self.machine.device).await?)
                }
            };
            if all_hits {
                return caster.cast_all(rays).await;
            }
            Ok(AllHits { rays: Vec::new(), hits: caster.cast(rays).await? })
        })
    }
}
