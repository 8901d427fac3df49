//! Records as dicts: the output of `decode` without formatting it as text.

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString};
use serde_json::Value;
use utm_fusion::json::Tree;

/// Cache of dict keys as Python strings.
pub(crate) struct Keys(Vec<Option<(&'static str, Py<PyString>)>>);

/// Number of slots of the cache; more than a category has keys, so that few collide.
const PLACES: usize = 4096;

impl Default for Keys {
    fn default() -> Self {
        Self(std::iter::repeat_with(|| None).take(PLACES).collect())
    }
}

impl Keys {
    fn get<'py>(&mut self, py: Python<'py>, key: &'static str) -> Bound<'py, PyString> {
        // Keys are static strings, so an address identifies a key.
        let place = &mut self.0[(key.as_ptr() as usize ^ key.len()) % PLACES];
        if let Some((known, made)) = place
            && std::ptr::eq(*known, key)
        {
            return made.bind(py).clone();
        }
        let made = PyString::intern(py, key);
        *place = Some((key, made.clone().unbind()));
        made
    }
}

/// Builds dicts.
pub(crate) struct Objects<'a, 'py> {
    py: Python<'py>,
    keys: &'a mut Keys,
    /// Open objects, the innermost last.
    open: Vec<Open<'py>>,
    /// Receives complete dicts.
    done: &'a mut dyn FnMut(Bound<'py, PyDict>),
    /// First error of Python.
    failed: Option<PyErr>,
}

enum Open<'py> {
    Dict(Bound<'py, PyDict>, Option<Bound<'py, PyString>>),
    List(Bound<'py, PyList>),
}

impl<'a, 'py> Objects<'a, 'py> {
    pub(crate) fn new(
        py: Python<'py>,
        keys: &'a mut Keys,
        done: &'a mut dyn FnMut(Bound<'py, PyDict>),
    ) -> Self {
        Self { py, keys, open: Vec::with_capacity(8), done, failed: None }
    }

    /// The error that occurred, if any, such as lack of memory.
    pub(crate) fn finish(self) -> PyResult<()> {
        self.failed.map_or(Ok(()), Err)
    }

    fn put<T>(&mut self, value: Bound<'py, T>) {
        let value = value.into_any();
        let put = match self.open.last_mut() {
            Some(Open::Dict(dict, key)) => match key.take() {
                Some(key) => dict.set_item(key, value),
                None => Ok(()),
            },
            Some(Open::List(list)) => list.append(value),
            None => Ok(()),
        };
        if let Err(error) = put {
            self.failed = Some(error);
        }
    }

    fn value(&mut self, value: &Value) {
        let py = self.py;
        match value {
            Value::Null => self.null(),
            Value::Bool(flag) => self.put(PyBool::new(py, *flag).to_owned()),
            Value::Number(number) => match (number.as_i64(), number.as_f64()) {
                (Some(whole), _) => self.put(PyInt::new(py, whole)),
                (None, Some(value)) => self.put(PyFloat::new(py, value)),
                (None, None) => self.null(),
            },
            Value::String(text) => self.text(text),
            Value::Array(values) => {
                self.open_array();
                values.iter().for_each(|value| self.value(value));
                self.close_array();
            }
            Value::Object(members) => {
                self.open_object();
                members.iter().for_each(|(key, value)| self.member(key, value));
                self.close_object();
            }
        }
    }
}

impl Tree for Objects<'_, '_> {
    fn open_object(&mut self) {
        self.open.push(Open::Dict(PyDict::new(self.py), None));
    }

    fn key(&mut self, key: &'static str) {
        let made = self.keys.get(self.py, key);
        if let Some(Open::Dict(_, key)) = self.open.last_mut() {
            *key = Some(made);
        }
    }

    fn close_object(&mut self) {
        let Some(Open::Dict(dict, _)) = self.open.pop() else { return };
        if self.open.is_empty() { (self.done)(dict) } else { self.put(dict) }
    }

    fn open_array(&mut self) {
        self.open.push(Open::List(PyList::empty(self.py)));
    }

    fn element(&mut self) {}

    fn close_array(&mut self) {
        let Some(Open::List(list)) = self.open.pop() else { return };
        self.put(list);
    }

    fn null(&mut self) {
        self.put(self.py.None().into_bound(self.py));
    }

    fn yes(&mut self) {
        self.put(PyBool::new(self.py, true).to_owned());
    }

    fn integer(&mut self, number: u64) {
        self.put(PyInt::new(self.py, number));
    }

    fn decimal(&mut self, value: f64, decimals: u8) {
        // The quotient of two integers is the double nearest to the decimal fraction.
        let scale = 10_u64.pow(u32::from(decimals)) as f64;
        let scaled = (value * scale).round() as i64;
        if decimals == 0 {
            self.put(PyInt::new(self.py, scaled));
        } else {
            self.put(PyFloat::new(self.py, scaled as f64 / scale));
        }
    }

    fn text(&mut self, text: &str) {
        self.put(PyString::new(self.py, text));
    }

    fn hex(&mut self, octets: &[u8]) {
        const DIGITS: &[u8; 16] = b"0123456789abcdef";
        let digits =
            |octet: &u8| [octet >> 4, octet & 0x0f].map(|digit| char::from(DIGITS[usize::from(digit)]));
        let text: String = octets.iter().flat_map(digits).collect();
        self.text(&text);
    }

    fn member(&mut self, key: &str, value: &Value) {
        let made = PyString::new(self.py, key);
        if let Some(Open::Dict(_, key)) = self.open.last_mut() {
            *key = Some(made);
        }
        self.value(value);
    }
}
