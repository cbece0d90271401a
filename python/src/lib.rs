//! What `preslide` for Python takes from the tool: its commands, run in this process, and its models.

use numpy::{PyArray1, PyReadonlyArray1};
use preslide_cli::call;
use preslide_fit::friction::Path;
use preslide_fit::model::{Measured, Model, Now, Stepper};
use preslide_fit::recording::MotionKind;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// What a command said, what it warned of, and why it failed with which exit code.
type Answer = (String, Vec<String>, Option<(String, u8)>);

/// Runs `preslide ARGUMENTS…`: what it said, what it warned of, and why it failed with which exit code. Without the interpreter's lock;
/// `progress` is called with what is being done, the steps done, and how many there are (0 where nobody knows).
#[pyfunction]
#[pyo3(signature = (arguments, progress=None))]
fn run(py: Python<'_>, arguments: Vec<String>, progress: Option<Py<PyAny>>) -> PyResult<Answer> {
    let failed: Arc<std::sync::Mutex<Option<PyErr>>> = Arc::default();
    let seen = failed.clone();
    let listener = Arc::new(move |what: &str, done: u64, of: u64| {
        if let Some(progress) = &progress {
            let told = Python::attach(|py| progress.call1(py, (what, done, of)).map(|_| ()));
            if let (Err(error), Ok(mut seen)) = (told, seen.lock()) {
                seen.get_or_insert(error);
            }
        }
    });
    let answer = py.detach(|| call(arguments, listener));
    let error = failed.lock().ok().and_then(|mut error| error.take());
    match error {
        Some(error) => Err(error),
        None => Ok((answer.said, answer.told, answer.failure)),
    }
}

/// A model file at work.
#[pyclass(name = "Model", module = "preslide._preslide", frozen)]
struct PyModel {
    model: Model,
    text: String,
}

#[pymethods]
impl PyModel {
    /// Reads the text of a model file.
    #[new]
    fn new(text: String) -> PyResult<Self> {
        let model = Model::parse(&text).map_err(PyValueError::new_err)?;
        Ok(Self { model, text })
    }

    /// The model file's text.
    fn to_toml(&self) -> &str {
        &self.text
    }

    /// Whether the axis turns.
    #[getter]
    fn rotary(&self) -> bool {
        self.model.motion == MotionKind::Rotary
    }

    /// Moving mass (kg) or moment of inertia (kg·m²); 0 where the model has none.
    #[getter]
    fn inertia(&self) -> f64 {
        self.model.inertia
    }

    /// Force (N or N·m) at which it breaks away from rest; `None` where its friction has no such force.
    #[getter]
    fn breakaway(&self) -> Option<f64> {
        self.model.friction.breakaway()
    }

    /// The same, a tick at a time: for `rate` ticks a second (Hz), from rest.
    fn stepper(&self, rate: f64) -> PyResult<PyStepper> {
        let own = Stepper::of(&self.model, 1.0 / rate).map_err(PyValueError::new_err)?;
        Ok(PyStepper {
            own: Mutex::new(own),
            model: self.model.clone(),
            rate,
        })
    }

    /// The force (N or N·m) that a motion takes at every sample: friction, viscous and constant force, every effect, and inertia where the
    /// acceleration is given.
    #[pyo3(signature = (t, x, v, a=None, temperature=None, load=None))]
    #[expect(clippy::too_many_arguments)]
    fn _force<'py>(
        &self,
        py: Python<'py>,
        t: PyReadonlyArray1<'py, f64>,
        x: PyReadonlyArray1<'py, f64>,
        v: PyReadonlyArray1<'py, f64>,
        a: Option<PyReadonlyArray1<'py, f64>>,
        temperature: Option<PyReadonlyArray1<'py, f64>>,
        load: Option<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let of = |array: &PyReadonlyArray1<'py, f64>| -> PyResult<Vec<f64>> {
            Ok(array.as_slice()?.to_vec())
        };
        let more = |array: &Option<PyReadonlyArray1<'py, f64>>| array.as_ref().map(of).transpose();
        let (t, x, v) = (of(&t)?, of(&x)?, of(&v)?);
        let (a, temperature, load) = (more(&a)?, more(&temperature)?, more(&load)?);
        let lengths = [
            Some(&x),
            Some(&v),
            a.as_ref(),
            temperature.as_ref(),
            load.as_ref(),
        ];
        if t.len() < 2
            || lengths
                .into_iter()
                .flatten()
                .any(|column| column.len() != t.len())
        {
            return Err(PyValueError::new_err(
                "t, x, v and what is given beside them need as many samples each, two at least",
            ));
        }
        let sample_time = (t[t.len() - 1] - t[0]) / (t.len() - 1) as f64;
        let whole = 0..t.len();
        let force = py.detach(|| {
            let path = Path {
                position: &x,
                velocity: &v,
                pieces: std::slice::from_ref(&whole),
                sample_time,
            };
            let measured = Measured {
                t_s: Some(&t),
                acceleration: a.as_deref(),
                temperature_c: temperature.as_deref(),
                load_n: load.as_deref(),
            };
            self.model.force_along(path, &measured)
        });
        let force = force.map_err(PyValueError::new_err)?;
        Ok(PyArray1::from_vec(py, force))
    }
}

/// A model at work, tick after tick.
#[pyclass(name = "Stepper", module = "preslide._preslide", frozen)]
struct PyStepper {
    own: Mutex<Stepper>,
    model: Model,
    rate: f64,
}

#[pymethods]
impl PyStepper {
    /// The force (N or N·m) that this tick takes at position `x` (m or rad). `v` (m/s or rad/s) is the way since the last tick over its time where
    /// it is not given; without `a` (m/s² or rad/s²) the force of the inertia is left out.
    #[pyo3(signature = (x, v=None, a=None, temperature=None, load=None))]
    fn step(
        &self,
        x: f64,
        v: Option<f64>,
        a: Option<f64>,
        temperature: Option<f64>,
        load: Option<f64>,
    ) -> PyResult<f64> {
        let now = Now {
            position: x,
            velocity: v,
            acceleration: a,
            temperature_c: temperature,
            load_n: load,
        };
        let mut own = self.own.lock().unwrap_or_else(PoisonError::into_inner);
        own.step(&now).map_err(PyValueError::new_err)
    }

    /// Back to rest, with nothing remembered.
    fn reset(&self) -> PyResult<()> {
        let fresh = Stepper::of(&self.model, 1.0 / self.rate).map_err(PyValueError::new_err)?;
        *self.own.lock().unwrap_or_else(PoisonError::into_inner) = fresh;
        Ok(())
    }
}

/// The tool in this process.
#[pymodule]
fn _preslide(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(run, module)?)?;
    module.add_class::<PyModel>()?;
    module.add_class::<PyStepper>()?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))
}
