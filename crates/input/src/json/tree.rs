//! Output of a record: JSON text, or the objects of another language.

use asterix::Joined;
use serde_json::Value;

use super::values::{write_decimal, write_hex, write_integer};

/// Builder of an object with its members in order. The implementation defines the output format; this module defines the content
/// once.
pub trait Tree {
    /// Begins an object: the root, the value of a key, or an element.
    fn open_object(&mut self);

    /// Begins a member; its value follows. Keys are known constants that need no escapes.
    fn key(&mut self, key: &'static str);

    /// Begins a member whose key has been joined with its JSON punctuation in advance.
    fn joined(&mut self, key: &'static str, _: &Joined) {
        self.key(key);
    }

    /// Ends an object.
    fn close_object(&mut self);

    /// Begins an array.
    fn open_array(&mut self);

    /// Begins an element; its value follows.
    fn element(&mut self);

    /// Ends an array.
    fn close_array(&mut self);

    /// An unknown value.
    fn null(&mut self);

    /// The value true.
    fn yes(&mut self);

    /// A whole number.
    fn integer(&mut self, number: u64);

    /// `value` with this number of decimals; a whole number if it is 0.
    fn decimal(&mut self, value: f64, decimals: u8);

    /// A text.
    fn text(&mut self, text: &str);

    /// Octets as a text of hexadecimal digits.
    fn hex(&mut self, octets: &[u8]);

    /// A member with any value.
    fn member(&mut self, key: &str, value: &Value);

    /// Ends the output after the root.
    fn end(&mut self) {}
}

/// JSON text, one line per root.
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
        // A fixed number of octets is copied without a call, then truncated.
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
