//! Scenes: built in, from files, or built from arrays; edited and saved.

use crate::columns::{self, Vector, elements, vectors};
use crate::errors::{FileError, InputError, SceneError, of_flaw};
use crate::shared::{Held, Shared};
use crate::values::{
    CameraTuple, MaterialTuple, SettingsTuple, camera, material, of_camera, of_material, of_settings,
    settings,
};
use crate::work::{work, work_until_interrupted};
use figure::stage;
use files::export::{self, Exported, View};
use files::{atomic_file, named, scene_file};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use scene::check::Part;
use scene::{Flaw, Rgb, Settings, Sphere, Stop, Vec3, check};
use std::io::Write as _;
use std::path::PathBuf;

/// Columns of new spheres: centres, radii, materials, emissions, velocities.
type NewSpheres<'py> = (
    PyReadonlyArray2<'py, f32>,
    PyReadonlyArray1<'py, f32>,
    PyReadonlyArray1<'py, u32>,
    PyReadonlyArray2<'py, f32>,
    PyReadonlyArray2<'py, f32>,
);

/// A scene. Its background is a colour, and not a sphere yet.
#[pyclass(frozen, module = "sppm._sppm")]
pub(crate) struct Scene {
    shared: Shared,
    /// The file that it was read from, which no output may overwrite.
    pub(crate) file: Option<PathBuf>,
    /// Whether it is a stage for particles, with settings that suit path tracing if there are neither mirrors nor glass.
    #[pyo3(get)]
    is_stage: bool,
}

impl Scene {
    fn new(scene: scene::Scene, file: Option<PathBuf>) -> Self {
        Self { shared: Shared::new(scene), file, is_stage: false }
    }

    /// A stage for particles.
    pub(crate) fn stage(scene: scene::Scene, file: Option<PathBuf>) -> Self {
        Self { is_stage: true, ..Self::new(scene, file) }
    }

    /// The scene, for other threads.
    pub(crate) fn shared(&self) -> Shared {
        self.shared.clone()
    }

    /// Changes the scene, which has no sky then, while other Python threads go on.
    pub(crate) fn edit<T: Send>(
        &self,
        py: Python,
        f: impl FnOnce(&mut scene::Scene) -> T + Send,
    ) -> PyResult<T> {
        work(py, || f(self.shared.lock().bare()))
    }

    /// The scene with its sky, as libraries expect it; the spheres are shared. It is not checked.
    pub(crate) fn with_sky(&self, py: Python) -> PyResult<scene::Scene> {
        work(py, || self.shared.lock().whole().clone())
    }

    /// Reads the scene, or changes what its sky does not depend on, while other Python threads go on.
    fn hold<T: Send>(&self, py: Python, f: impl FnOnce(&mut Held) -> T + Send) -> PyResult<T> {
        work(py, || f(&mut self.shared.lock()))
    }

    /// Reads the scene with its sky.
    fn read_whole<T: Send>(&self, py: Python, f: impl FnOnce(&scene::Scene) -> T + Send) -> PyResult<T> {
        work(py, || f(self.shared.lock().whole()))
    }
}

#[pymethods]
impl Scene {
    /// An empty scene, which is a stage for particles if it `is_stage`.
    #[new]
    fn empty(name: String, is_stage: bool) -> Self {
        let scene = scene::Scene {
            name,
            camera: scene::Camera::default(),
            materials: Vec::new(),
            spheres: Vec::new().into(),
            background: Rgb::ZERO,
            transparent_background: false,
            imports: Vec::new(),
            settings: Settings::default(),
        };
        Self { is_stage, ..Self::new(scene, None) }
    }

    /// The built-in scene of this name, or the scene in this file; and notes.
    #[staticmethod]
    fn load(py: Python, name: PathBuf) -> PyResult<(Self, Vec<String>)> {
        let open = move || named::open(name.as_os_str(), [None; 2], u64::MAX);
        let opened = work_until_interrupted(py, &Stop::new(), open)?.map_err(SceneError::new_err)?;
        Ok((Self { is_stage: opened.is_staged, ..Self::new(opened.scene, opened.file) }, opened.notes))
    }

    /// The scene of a scene file's text.
    #[staticmethod]
    fn parse(py: Python, text: String, name: String) -> PyResult<Self> {
        let parse = move || scene_file::parse(&name, &text);
        let parsed = work_until_interrupted(py, &Stop::new(), parse)?;
        Ok(Self::new(parsed.map_err(|error| SceneError::new_err(error.to_string()))?, None))
    }

    fn copy(&self, py: Python) -> PyResult<Self> {
        let shared = work(py, || self.shared.copy())?;
        Ok(Self { shared, file: self.file.clone(), is_stage: self.is_stage })
    }

    #[getter]
    fn name(&self, py: Python) -> PyResult<String> {
        self.hold(py, |held| held.scene.name.clone())
    }

    #[setter]
    fn set_name(&self, py: Python, name: String) -> PyResult<()> {
        self.hold(py, |held| held.scene.name = name)
    }

    #[getter]
    fn background(&self, py: Python) -> PyResult<[f32; 3]> {
        self.hold(py, |held| held.scene.background.to_array())
    }

    #[setter]
    fn set_background(&self, py: Python, background: [f32; 3]) -> PyResult<()> {
        let background = Rgb::from_array(background);
        check::check_radiance(Part::Scene, "background", background).map_err(|flaw| of_flaw(&flaw))?;
        self.edit(py, |scene| scene.background = background)
    }

    #[getter]
    fn transparent_background(&self, py: Python) -> PyResult<bool> {
        self.hold(py, |held| held.scene.transparent_background)
    }

    #[setter]
    fn set_transparent_background(&self, py: Python, is_transparent: bool) -> PyResult<()> {
        self.hold(py, |held| held.scene.transparent_background = is_transparent)
    }

    #[getter]
    fn camera(&self, py: Python) -> PyResult<CameraTuple> {
        self.hold(py, |held| of_camera(&held.scene.camera))
    }

    #[setter]
    fn set_camera(&self, py: Python, values: CameraTuple) -> PyResult<()> {
        self.edit(py, |scene| scene.camera = camera(values))
    }

    #[getter]
    fn settings(&self, py: Python) -> PyResult<SettingsTuple> {
        self.hold(py, |held| of_settings(&held.scene.settings))
    }

    #[setter]
    fn set_settings(&self, py: Python, values: SettingsTuple) -> PyResult<()> {
        let settings = settings(values)?;
        self.hold(py, |held| held.scene.settings = settings)
    }

    #[getter]
    fn materials(&self, py: Python) -> PyResult<Vec<MaterialTuple>> {
        self.hold(py, |held| held.materials().iter().map(of_material).collect())
    }

    #[getter]
    fn material_count(&self, py: Python) -> PyResult<usize> {
        self.hold(py, |held| held.materials().len())
    }

    /// Whether there are neither mirrors nor glass.
    fn is_matte(&self, py: Python) -> PyResult<bool> {
        self.hold(py, |held| stage::is_matte(held.materials()))
    }

    /// Appends a material; returns its index.
    fn add_material(&self, py: Python, values: MaterialTuple) -> PyResult<usize> {
        let material = material(values)?;
        self.edit(py, |scene| {
            scene.materials.push(material);
            scene.materials.len() - 1
        })
    }

    /// Replaces a material.
    fn set_material(&self, py: Python, index: usize, values: MaterialTuple) -> PyResult<()> {
        let material = material(values)?;
        self.edit(py, |scene| {
            let materials = scene.materials.len();
            scene.materials.get_mut(index).map(|old| *old = material).ok_or(materials)
        })?
        .map_err(|materials| {
            SceneError::new_err(format!("there is no material [{index}]; the scene has {materials}"))
        })
    }

    fn __len__(&self, py: Python) -> PyResult<usize> {
        self.hold(py, |held| held.spheres().len())
    }

    /// Makes room for so many more spheres, without more memory than they need.
    fn reserve(&self, py: Python, more: usize) -> PyResult<()> {
        self.edit(py, |scene| scene.spheres.try_reserve_exact(more))?
            .map_err(|_| PyMemoryError::new_err(format!("there is no memory for {more} spheres")))
    }

    /// Appends spheres. The first of them is called number `first` in messages.
    fn append(&self, py: Python, columns: NewSpheres, first: usize) -> PyResult<()> {
        let (centers, radii, materials, emissions, velocities) = columns;
        let (centers, radii, materials) = (vectors(&centers)?, elements(&radii)?, elements(&materials)?);
        let (emissions, velocities) = (vectors(&emissions)?, vectors(&velocities)?);
        let n = centers.len();
        if [radii.len(), materials.len(), emissions.len(), velocities.len()] != [n; 4] {
            return Err(InputError::new_err("the columns differ in length"));
        }
        let sphere = |i: usize| Sphere {
            center: Vec3::from_array(centers[i]),
            velocity: Vec3::from_array(velocities[i]),
            radius: radii[i],
            material: materials[i],
            emission: Rgb::from_array(emissions[i]),
        };
        self.edit(py, |scene| {
            let known = scene.materials.len();
            let checked = |i: usize| {
                check::check_sphere(Part::Sphere(first + i), &sphere(i), known).map(|()| sphere(i))
            };
            let before = scene.spheres.len();
            let added = (0..n).try_for_each(|i| checked(i).map(|sphere| scene.spheres.push(sphere)));
            added.inspect_err(|_| scene.spheres.truncate(before))
        })?
        .map_err(|flaw| of_flaw(&flaw))
    }

    /// Removes all but the first `spheres` and `materials`.
    fn truncate(&self, py: Python, spheres: usize, materials: usize) -> PyResult<()> {
        self.edit(py, |scene| {
            scene.spheres.truncate(spheres);
            scene.spheres.shrink_to_fit();
            scene.materials.truncate(materials);
        })
    }

    /// Keeps the spheres for which `kept` is true.
    fn retain(&self, py: Python, kept: PyReadonlyArray1<bool>) -> PyResult<()> {
        let kept = elements(&kept)?;
        self.edit(py, |scene| {
            check_length(scene, kept.len())?;
            let mut kept = kept.iter();
            scene.spheres.retain(|_| kept.next() == Some(&true));
            Ok(())
        })?
    }

    /// The vectors called `name` of all spheres.
    fn vectors<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let vector = Vector::named(name)?;
        let all = self.hold(py, |held| held.spheres().iter().map(|s| vector.get(s)).collect())?;
        columns::rows(py, all)
    }

    /// The radii of all spheres.
    fn radii<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let all = self.hold(py, |held| held.spheres().iter().map(|s| s.radius).collect())?;
        columns::values(py, all)
    }

    /// The materials' indices of all spheres.
    fn material_indices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let all = self.hold(py, |held| held.spheres().iter().map(|s| s.material).collect())?;
        columns::values(py, all)
    }

    /// Replaces the vectors called `name` of all spheres.
    fn set_vectors(&self, py: Python, name: &str, values: PyReadonlyArray2<f32>) -> PyResult<()> {
        let (vector, values) = (Vector::named(name)?, vectors(&values)?);
        self.change(py, values.len(), |sphere, i| vector.set(sphere, values[i]))
    }

    /// Replaces all radii.
    fn set_radii(&self, py: Python, values: PyReadonlyArray1<f32>) -> PyResult<()> {
        let values = elements(&values)?;
        self.change(py, values.len(), |sphere, i| sphere.radius = values[i])
    }

    /// Replaces all materials' indices.
    fn set_material_indices(&self, py: Python, values: PyReadonlyArray1<u32>) -> PyResult<()> {
        let values = elements(&values)?;
        self.change(py, values.len(), |sphere, i| sphere.material = values[i])
    }

    /// Checks that the scene can be rendered.
    fn check(&self, py: Python) -> PyResult<()> {
        self.read_whole(py, scene::Scene::check)?.map_err(|flaw| of_flaw(&flaw))
    }

    /// The scene file.
    fn to_text(&self, py: Python) -> PyResult<String> {
        self.read_whole(py, |scene| scene_file::to_text(scene, &scene.settings))
    }

    /// Identifies the scene, without its settings.
    fn digest(&self, py: Python) -> PyResult<String> {
        self.read_whole(py, scene_file::digest)
    }

    /// Writes the scene file.
    fn save(&self, py: Python, path: PathBuf) -> PyResult<()> {
        let text = self.to_text(py)?;
        let written = work(py, || atomic_file::replace(&path, |out| out.write_all(text.as_bytes())))?;
        written.map_err(|error| FileError::new_err(error.to_string()))
    }

    /// The scene at one instant as a file for another renderer, and notes on what differs.
    fn export(&self, py: Python, renderer: &str, time: f32, samples: u32) -> PyResult<(String, Vec<String>)> {
        let renderer = match renderer {
            "mitsuba" => export::Renderer::Mitsuba,
            "pbrt" => export::Renderer::Pbrt,
            _ => {
                let problem = format!("format {renderer:?}: there is no such; it is \"mitsuba\" or \"pbrt\"");
                return Err(InputError::new_err(problem));
            }
        };
        let shared = self.shared();
        let scene = work(py, || shared.checked())??;
        let written = work(py, || {
            let Settings { width, height, filter, .. } = scene.settings;
            let (name, camera, still) = (&scene.name, &scene.camera, &scene.at(time));
            let version = env!("CARGO_PKG_VERSION");
            export::write(
                renderer,
                &View { name, camera, still, time, width, height, filter, samples, version },
            )
        })?;
        written.map(|Exported { text, notes }| (text, notes)).map_err(SceneError::new_err)
    }
}

impl Scene {
    /// Changes every sphere by `change`, which gets its index, or none if one of them is then out of range.
    fn change(
        &self,
        py: Python,
        length: usize,
        change: impl Fn(&mut Sphere, usize) + Send + Sync,
    ) -> PyResult<()> {
        self.edit(py, |scene| {
            check_length(scene, length)?;
            let materials = scene.materials.len();
            let check = |(i, sphere): (usize, &Sphere)| -> Result<(), Flaw> {
                let mut sphere = *sphere;
                change(&mut sphere, i);
                check::check_sphere(Part::Sphere(i), &sphere, materials)
            };
            scene.spheres.iter().enumerate().try_for_each(check).map_err(|flaw| of_flaw(&flaw))?;
            scene.spheres.iter_mut().enumerate().for_each(|(i, sphere)| change(sphere, i));
            Ok(())
        })?
    }
}

fn check_length(scene: &scene::Scene, length: usize) -> PyResult<()> {
    let spheres = scene.spheres.len();
    if length == spheres {
        return Ok(());
    }
    Err(SceneError::new_err(format!("{length} values are given for {spheres} spheres")))
}

/// The names of the built-in scenes, with a line about each.
#[pyfunction]
pub(crate) fn builtin_scenes() -> Vec<(&'static str, &'static str)> {
    files::builtin::SCENES.iter().map(|scene| (scene.name, scene.about)).collect()
}

/// Checks every number of a camera.
#[pyfunction]
pub(crate) fn check_camera(values: CameraTuple) -> PyResult<()> {
    check::check_camera(&camera(values)).map_err(|flaw| of_flaw(&flaw))
}

/// Checks every number of a material, which messages call `name`.
#[pyfunction]
pub(crate) fn check_material(values: MaterialTuple, name: &str) -> PyResult<()> {
    let checked = check::check_material(Part::Material(0), &material(values)?);
    checked.map_err(|flaw| SceneError::new_err(flaw.say(|_| name.into())))
}
