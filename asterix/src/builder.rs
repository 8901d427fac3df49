//! Builders: a record is built of items that are there, or the item that is not is named.

/// Why a record was not built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
pub enum BuildError {
    /// The constructor of this item gave `None`: a value was out of its range.
    #[error("CAT{category:03} item {item}: a value is out of the range that the item can hold")]
    OutOfRange {
        /// The category.
        category: u8,
        /// Number of the item.
        item: &'static str,
    },
    /// None of these items, of which the specification wants one, is there.
    #[error("CAT{category:03}: one of the items {items} must be there")]
    Missing {
        /// The category.
        category: u8,
        /// Numbers of the items.
        items: &'static str,
    },
}

/// Makes the builder of a category's record: the items that every record must have, then the others.
///
/// An item may be given as it is or as the `Option` that its constructor returns. `None` is a mistake and not an absent
/// item: [`BuildError::OutOfRange`]. The first mistake counts.
macro_rules! builder {
    (
        $category:literal,
        must { $($must:ident: $must_type:ty = $must_item:literal,)* }
        may { $($may:ident: $may_type:ty = $may_item:literal,)* }
        $(one_of $items:literal { $($one:ident)|* })?
    ) => {
        #[doc = concat!("Builds a CAT", stringify!($category), " record that lacks nothing it must have.")]
        #[derive(Clone, Debug)]
        #[must_use]
        pub struct Builder {
            record: Record,
            mistake: Option<$crate::BuildError>,
        }

        impl Record {
            /// Begins a record with the items that every record must have; a `None` is told by [`Builder::build`].
            pub fn builder($($must: impl Into<Option<$must_type>>),*) -> Builder {
                let mut builder = Builder { record: Record::default(), mistake: None };
                $(builder.record.$must = builder.checked($must_item, $must.into());)*
                builder
            }
        }

        impl Builder {
            $(
                #[doc = concat!("With item ", $may_item, ".")]
                pub fn $may(mut self, item: impl Into<Option<$may_type>>) -> Self {
                    self.record.$may = self.checked($may_item, item.into());
                    self
                }
            )*

            /// The record.
            ///
            /// # Errors
            /// An item was `None`: its constructor found a value out of range. Or a record must have one of several items
            /// and has none.
            pub fn build(self) -> Result<Record, $crate::BuildError> {
                if let Some(mistake) = self.mistake {
                    return Err(mistake);
                }
                $(if $(self.record.$one.is_none())&&* {
                    return Err($crate::BuildError::Missing { category: $category, items: $items });
                })?
                Ok(self.record)
            }

            fn checked<T>(&mut self, number: &'static str, item: Option<T>) -> Option<T> {
                if item.is_none() && self.mistake.is_none() {
                    self.mistake = Some($crate::BuildError::OutOfRange { category: $category, item: number });
                }
                item
            }
        }
    };
}

pub(crate) use builder;
