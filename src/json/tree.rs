//! What a record becomes: the text of JSON, or the objects of another language.

use asterix::Joined;
use serde_json::Value;

use super::values::{write_decimal, write_hex, write_integer};

/// An object that is being made, its members in order. What it is made of decides how it looks; what is in it is said once,
/// here in `json`.
pub trait Tree {
    /// Begins an object: the root, the value of a key, or an element.
    fn open_object(&mut self);

    /// Begins a member; its value is made next. Keys need no escapes: they are ours.
    fn key(&mut self, key: &'static str);

    /// The same of a key that is joined beforehand to what JSON puts around it.
    fn joined(&mut self, key: &'static str, _: &Joined) {
        self.key(key);
    }

    /// Ends it.
    fn close_object(&mut self);

    /// Begins an array.
    fn open_array(&mut self);

    /// Begins an element; its value is made next.
    fn element(&mut self);

    /// Ends it.
    fn close_array(&mut self);

    /// What is not known.
    fn null(&mut self);

    /// What is so.
    fn yes(&mut self);

    /// A whole number.
    fn integer(&mut self, number: u64);

    /// `value` with so many decimals; a whole number where that is 0.
    fn decimal(&mut self, value: f64, decimals: u8);

    /// A text.
    fn text(&mut self, text: &str);

    /// Octets as a text of hexadecimal digits.
    fn hex(&mut self, octets: &[u8]);

    /// A member of any value.
    fn member(&mut self, key: &str, value: &Value);

    /// Nothing follows the root.
    fn end(&mut self) {}
}

/// JSON, a line for each root.
impl Tree for Vec<u8> {
    fn open_object(&mut self) {
        self.push(b'{');
    }

    fn key(&mut self, key: &'static str) {
        let is_first = self.last() == Some(&b'{');
        self.extend_from_slice(if is_first { b"\"" } else { b",\"" });
        self.extend_from_slice(key.as_bytes());
        self.extend_from_slice(b"\":");
    }

    fn joined(&mut self, key: &'static str, joined: &Joined) {
        let Some((text, length)) = joined.text() else { return self.key(key) };
        // A fixed number of octets is copied without a call; those that are too many are cut off again.
        let start = self.len();
        if self.last() == Some(&b'{') {
            self.extend_from_slice(&text[1..]);
            self.truncate(start + length - 1);
        } else {
            self.extend_from_slice(text);
            self.truncate(start + length);
        }
    }

    fn close_object(&mut self) {
        self.push(b'}');
    }

    fn open_array(&mut self) {
        self.push(b'[');
    }

    fn element(&mut self) {
        if self.last() != Some(&b'[') {
            self.push(b',');
        }
    }

    fn close_array(&mut self) {
        self.push(b']');
    }

    fn null(&mut self) {
        self.extend_from_slice(b"null");
    }

    fn yes(&mut self) {
        self.extend_from_slice(b"true");
    }

    fn integer(&mut self, number: u64) {
        write_integer(self, number);
    }

    fn decimal(&mut self, value: f64, decimals: u8) {
        write_decimal(self, value, decimals);
    }

    fn text(&mut self, text: &str) {
        let is_plain = |octet: &u8| matches!(octet, b' '..=b'~') && !matches!(octet, b'"' | b'\\');
        if text.as_bytes().iter().all(is_plain) {
            self.push(b'"');
            self.extend_from_slice(text.as_bytes());
            self.push(b'"');
        } else {
            serde_json::to_writer(self, text).expect("writing to a vector cannot fail");
        }
    }

    fn hex(&mut self, octets: &[u8]) {
        write_hex(self, octets);
    }

    fn member(&mut self, key: &str, value: &Value) {
        if self.last() != Some(&b'{') {
            self.push(b',');
        }
        self.text(key);
        self.push(b':');
        serde_json::to_writer(self, value).expect("writing to a vector cannot fail");
    }

    fn end(&mut self) {
        self.push(b'\n');
    }
}
