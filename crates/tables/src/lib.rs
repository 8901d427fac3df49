//! TOML tables whose keys are each defined once, by [`section!`]. The definition of a key yields the field of its type, its
//! default, how it is read, checked and shown, whether a reload takes it, and its row of a reference page.
//!
//! Text → [`tree`] (values with their lines) → [`reader`] (reads known keys, refuses the others) → tables. All errors are
//! found, not only the first; each names its file, line and key ([`error`]).
//!
//! ```
//! use tables::error::{ConfigErrors, Faults};
//! use tables::kinds::{any_text, number};
//! use tables::reader::Section;
//! use tables::table::{Table, need};
//! use tables::{section, tree};
//!
//! section! {
//!     /// A mast.
//!     Mast {
//!         /// what it is called
//!         name: String = need("name = …"), any_text();
//!         /// how high it is, metres
//!         height_m: f64 = 10.0, number("a mast is up to 300 m high", |metres| (0.0..=300.0).contains(&metres));
//!     }
//! }
//!
//! fn read(text: &str) -> Result<Mast, ConfigErrors> {
//!     let faults = Faults::new("mast.toml");
//!     let root = tree::parse(text, &faults);
//!     faults.check()?;
//!     let mast = Mast::read(Section::top(&root, &faults));
//!     faults.check()?;
//!     Ok(mast)
//! }
//!
//! assert_eq!(read("name = \"north\"").unwrap().height_m, 10.0);
//! assert_eq!(
//!     read("height_m = 900\nhight_m = 9").unwrap_err().to_string(),
//!     "mast.toml: name: this key is missing; add name = …\n\
//!      mast.toml:1: height_m = 900: a mast is up to 300 m high\n\
//!      mast.toml:2: hight_m: this key is unknown; did you mean height_m? expected here: name, height_m",
//! );
//! ```

pub mod error;
pub mod kinds;
pub mod named;
pub mod reader;
pub mod table;
pub mod tree;
