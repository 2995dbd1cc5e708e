//! Exceptions: those of the package, with the sentences of the libraries.

use pyo3::{PyErr, import_exception};
use render::{Error, Field, Problem};
use scene::Flaw;
use scene::check::Part;

import_exception!(sppm._errors, FileError);
import_exception!(sppm._errors, InputError);
import_exception!(sppm._errors, RenderError);
import_exception!(sppm._errors, SceneError);

/// The exception for an error of a render.
pub(crate) fn of_render(error: &Error) -> PyErr {
    match error {
        Error::Input { field: Field::Scene, problem } => SceneError::new_err(say(problem)),
        Error::Input { field: Field::Resumed | Field::Like, problem } => FileError::new_err(say(problem)),
        Error::Input { problem, .. } => InputError::new_err(say(problem)),
        Error::Failed(problem) => RenderError::new_err(say(problem)),
    }
}

/// The sentence, with the names of Python's arguments.
fn say(problem: &Problem) -> String {
    problem.say(|field| match field {
        Field::Resume => "sppm.Render.resume".into(),
        field => field.name().into(),
    })
}

/// The exception for what is wrong with a scene. Indices in its message count from 0.
pub(crate) fn of_flaw(flaw: &Flaw) -> PyErr {
    SceneError::new_err(flaw.say(|part| match part {
        Part::Scene => "the scene".into(),
        Part::Camera => "the camera".into(),
        Part::Material(i) => format!("material [{i}]"),
        Part::Sphere(i) => format!("sphere [{i}]"),
    }))
}
