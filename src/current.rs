//! A value that is replaced while others use it: what a SIGHUP changes.

use std::sync::{Arc, PoisonError, RwLock};

/// A handle of such a value; its clones see the same one. Whoever took the value keeps what he took.
#[derive(Debug)]
pub struct Current<T>(Arc<RwLock<Arc<T>>>);

impl<T> Current<T> {
    /// As it is now.
    pub fn get(&self) -> Arc<T> {
        self.0.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// From now on it is this one. Nobody waits for longer than that takes.
    pub fn replace(&self, value: T) {
        *self.0.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(value);
    }
}

impl<T> Clone for Current<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T> From<T> for Current<T> {
    fn from(value: T) -> Self {
        Self(Arc::new(RwLock::new(Arc::new(value))))
    }
}

impl<T: Default> Default for Current<T> {
    fn default() -> Self {
        T::default().into()
    }
}
