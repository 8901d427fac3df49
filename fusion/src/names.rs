//! Interface names of enumeration values.

/// Defines the names of an enumeration's values on every interface: the constants `ALL` and `NAMES`, in this order, and
/// the method `name`. Omitting a value is a compile error, so no list of names can miss one.
///
/// ```
/// #[derive(Clone, Copy)]
/// enum Light {
///     Red,
///     Green,
/// }
///
/// utm_fusion_engine::interface_names!(Light { Red = "red", Green = "green" });
/// assert_eq!(Light::NAMES, Light::ALL.map(Light::name));
/// ```
#[macro_export]
macro_rules! interface_names {
    ($type:ty { $($value:ident = $text:literal),* $(,)? }) => {
        impl $type {
            /// All values.
            pub const ALL: [Self; [$($text),*].len()] = [$(Self::$value),*];

            /// The names of all values, in the order of `ALL`.
            pub const NAMES: [&'static str; [$($text),*].len()] = [$($text),*];

            /// Name on every interface.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$value => $text),* }
            }
        }
    };
}
