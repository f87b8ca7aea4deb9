//! Energy densities written in Python, and calls into them from the engine's threads.
//!
//! A scene names a law by a number; the functions behind it live in a table of the process. A session takes them when it is opened and
//! keeps them, so a law may be dropped before the session is.

use super::failure::{Failure, contained, install_panic_hook};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pliant_host::Library;
use pliant_plugin_api::Fault;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, Once, PoisonError};

/// Entries of a deformation gradient or a stress, row-major.
pub const ENTRIES: usize = 9;

/// The functions of a law. Each takes deformation gradients (n x 3 x 3) and gives a contiguous flat array of float64.
pub struct Functions {
    /// Energy densities, J/m^3 (n).
    energy: Py<PyAny>,
    /// First Piola-Kirchhoff stresses, Pa (n x 9).
    stress: Py<PyAny>,
    /// Second derivatives of the energy density, Pa (n x 81); its second argument is whether they are made positive semi-definite.
    stiffness: Py<PyAny>,
    /// The first exception of a function since it was last taken.
    error: Mutex<Option<PyErr>>,
}

/// Laws by number.
static LAWS: Mutex<BTreeMap<u64, Arc<Functions>>> = Mutex::new(BTreeMap::new());
/// Whether Ctrl-C was pressed while a function of a law ran.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// The law under test on this thread: the one that a material without a number has.
    static UNDER_TEST: Cell<Option<u64>> = const { Cell::new(None) };
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A law as Python holds it; scenes can name it as long as this object lives.
#[pyclass(frozen, module = "pliant._native")]
pub struct Law {
    /// What scenes call it.
    #[pyo3(get)]
    number: u64,
    functions: Arc<Functions>,
}

#[pymethods]
impl Law {
    /// Functions of a law; `library` is the file of this module, which is the library of their material plugin too.
    #[new]
    fn new(energy: Py<PyAny>, stress: Py<PyAny>, stiffness: Py<PyAny>, library: PathBuf) -> PyResult<Self> {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        static OPENED: Once = Once::new();
        let open = || Library::open(&library.canonicalize()?).map(drop).map_err(Failure::from);
        contained(open)?;
        // Opening a plugin library sets a panic hook in that library, which here is this module.
        OPENED.call_once(install_panic_hook);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let functions = Arc::new(Functions { energy, stress, stiffness, error: Mutex::new(None) });
        lock(&LAWS).insert(number, Arc::clone(&functions));
        Ok(Self { number, functions })
    }

    /// The first exception of its functions since the last call; `None` if there was none.
    fn take_error(&self) -> Option<PyErr> {
        lock(&self.functions.error).take()
    }
}

impl Drop for Law {
    fn drop(&mut self) {
        let functions = lock(&LAWS).remove(&self.number);
        drop(functions);
    }
}

impl Law {
    /// Does `work` with this law under test on this thread.
    pub fn under_test<R>(&self, work: impl FnOnce() -> R) -> R {
        let before = UNDER_TEST.replace(Some(self.number));
        let done = work();
        UNDER_TEST.set(before);
        done
    }
}

impl Functions {
    /// The functions of the law with a number; without one, of the law under test.
    pub fn find(number: Option<&str>) -> Result<Arc<Self>, Fault> {
        let number = number.map_or_else(|| UNDER_TEST.get(), |text| text.parse().ok());
        number.and_then(|number| lock(&LAWS).get(&number).cloned()).ok_or_else(|| {
            Fault::bad_argument("no such law in this process; allowed is a pliant.Hyperelastic that still exists")
        })
    }

    /// Energy densities of deformation gradients (n x 9), J/m^3 (n).
    pub fn energy(&self, gradients: Vec<f64>) -> Result<Vec<f64>, Fault> {
        self.call(gradients, 1, |gradients| self.energy.bind(gradients.py()).call1((gradients,)))
    }

    /// First Piola-Kirchhoff stresses of deformation gradients (n x 9), Pa (n x 9).
    pub fn stress(&self, gradients: Vec<f64>) -> Result<Vec<f64>, Fault> {
        self.call(gradients, ENTRIES, |gradients| self.stress.bind(gradients.py()).call1((gradients,)))
    }

    /// Second derivatives of the energy density at deformation gradients (n x 9), Pa (n x 81).
    pub fn stiffness(&self, gradients: Vec<f64>, project: bool) -> Result<Vec<f64>, Fault> {
        let function = &self.stiffness;
        self.call(gradients, ENTRIES * ENTRIES, |gradients| function.bind(gradients.py()).call1((gradients, project)))
    }

    /// Calls a function that gives `width` numbers for each of the gradients. An exception is kept and becomes a fault.
    fn call(
        &self,
        gradients: Vec<f64>,
        width: usize,
        function: impl for<'py> Fn(Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>>,
    ) -> Result<Vec<f64>, Fault> {
        let count = gradients.len() / ENTRIES;
        if count == 0 {
            return Ok(Vec::new());
        }
        let called = Python::attach(|py| {
            let argument = || PyArray1::from_slice(py, &gradients).reshape([count, 3, 3]).map(Bound::into_any);
            let mut result = function(argument()?);
            // Functions have no side effects, so the call under way is made again and the steps end after it.
            if result.as_ref().is_err_and(|error| error.is_instance_of::<PyKeyboardInterrupt>(py)) {
                INTERRUPTED.store(true, Ordering::Relaxed);
                result = function(argument()?);
            }
            let array: PyReadonlyArray1<'_, f64> = result?.extract()?;
            Ok(array.as_slice()?.to_vec())
        });
        let values = called.map_err(|error: PyErr| {
            let fault = Fault::diverged(Python::attach(|py| format!("{}", error.value(py))));
            lock(&self.error).get_or_insert(error);
            fault
        })?;
        if values.len() != width * count {
            return Err(Fault::diverged(format!("{} numbers for {count} elements; {width} each", values.len())));
        }
        match values.iter().position(|value| !value.is_finite()) {
            Some(at) => Err(Fault::diverged(format!("a value of the law is {} (element {})", values[at], at / width))),
            None => Ok(values),
        }
    }
}

/// Raises what signal handlers raise, and `KeyboardInterrupt` if Ctrl-C was pressed inside of a law.
pub fn check_signals(py: Python<'_>) -> PyResult<()> {
    py.check_signals()?;
    if INTERRUPTED.swap(false, Ordering::Relaxed) { Err(PyKeyboardInterrupt::new_err(())) } else { Ok(()) }
}
