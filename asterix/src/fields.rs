//! Fields of an item: their bits, accessors and setters, and the tables of their codes. The kinds of fields are listed in
//! [`item`](crate::item).

/// The descriptions of several fields.
macro_rules! fields {
    ($(
        $(#[$doc:meta])* $kind:ident $bits:literal $key:literal $($get:ident $(/ $set:ident)?)? $(: $type:ty)?
        $(= $scale:expr $(, $decimals:literal)?)?;
    )*) => {
        &[$($crate::layout::field($key, $bits, $crate::fields::kind!($kind $bits $(, $scale $(, $decimals)?)?)),)*]
    };
}

/// The [`Kind`](crate::Kind) of a field.
macro_rules! kind {
    (spare $bits:literal) => {
        $crate::Kind::Spare
    };
    (octal $bits:literal) => {
        $crate::Kind::Octal
    };
    (hex $bits:literal) => {
        $crate::Kind::Hex
    };
    (address $bits:literal) => {
        $crate::Kind::Address
    };
    (ascii $bits:literal) => {
        $crate::Kind::Ascii
    };
    (icao $bits:literal) => {
        $crate::Kind::Icao
    };
    (constant $bits:literal, $value:expr) => {
        $crate::Kind::Constant($value)
    };
    (count_or $bits:literal, $unknown:expr) => {
        $crate::Kind::CountOr($unknown)
    };
    (count_from $bits:literal, $first:expr) => {
        $crate::Kind::CountFrom($first)
    };
    (signed $bits:literal, $lsb:expr, $decimals:literal) => {
        $crate::layout::quantity(true, $lsb, $decimals)
    };
    (signed_per $bits:literal, $counts:expr, $decimals:literal) => {
        $crate::layout::quantity(true, 1.0 / $counts, $decimals)
    };
    (known $bits:literal, $lsb:expr, $decimals:literal) => {
        $crate::Kind::Quantity($crate::Quantity {
            signed: false,
            lsb: $lsb,
            decimals: $decimals,
            unknown: Some($crate::bits::mask($bits)),
        })
    };
    ($physical:ident $bits:literal, $lsb:expr, $decimals:literal) => {
        $crate::layout::quantity(false, $lsb, $decimals)
    };
    ($whole:ident $bits:literal) => {
        $crate::Kind::Count
    };
}

/// Accessors and setters of fields. The functions of the module `$store` read and replace their bits.
macro_rules! accessors {
    ($name:ident $store:ident $(
        $(#[$doc:meta])* $kind:ident $bits:literal $key:literal $($get:ident $(/ $set:ident)?)? $(: $type:ty)?
        $(= $scale:expr $(, $decimals:literal)?)?;
    )*) => {
        $($crate::fields::accessor! {
            $kind [$name $store $bits $key] [$(#[$doc])*] [$($get $(/ $set)?)?] [$($type)?] [$($scale)?]
        })*
    };
}

/// The accessor and the setter of a field, if it has them.
macro_rules! accessor {
    ($kind:ident $field:tt $doc:tt [] $type:tt $scale:tt) => {};
    (flag $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [] []) => {
        $crate::fields::accessor!(@get $field $doc $get: bool, count => count == 1);
        $($crate::fields::accessor!(@set $field $get $set(flag: bool) flag as u64);)?
    };
    (unset $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [] []) => {
        $crate::fields::accessor!(@get $field $doc $get: bool, count => count == 0);
        $($crate::fields::accessor!(@set $field $get $set(flag: bool) !flag as u64);)?
    };
    (code $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [$type:ty] []) => {
        $crate::fields::accessor!(@get $field $doc $get: $type, count => <$type>::from_code(count as u8));
        $($crate::fields::accessor!(@set $field $get $set(code: $type) code.code() as u64);)?
    };
    (count_from $field:tt $doc:tt [$get:ident] [$type:ty] [$first:expr]) => {
        $crate::fields::accessor!(@get $field $doc $get: $type, count => count as $type + $first);
    };
    (populated $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [$type:ty] []) => {
        $crate::fields::accessor!(@get_populated $field $doc $get: $type, count => count as $type);
        $($crate::fields::accessor!(@whole_populated $field $get $set: $type);)?
    };
    (populated_flag $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [] []) => {
        $crate::fields::accessor!(@get_populated $field $doc $get: bool, count => count == 1);
        $($crate::fields::accessor!(@set_populated $field $get $set);)?
    };
    (unsigned $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [] [$lsb:expr]) => {
        $crate::fields::accessor!(@get $field $doc $get: f64, count => count as f64 * ($lsb));
        $($crate::fields::accessor!(@nearest $field $get $set(value) value / ($lsb), 0, false);)?
    };
    (angle $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [] [$lsb:expr]) => {
        $crate::fields::accessor!(@get $field $doc $get: f64, count => count as f64 * ($lsb));
        // The rounded count may be that of a whole turn, which needs one more bit; it is the same as 0.
        $($crate::fields::accessor!(@nearest $field $get $set(value) $crate::bits::turned(value) / ($lsb), 1, false);)?
    };
    (signed $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [] [$lsb:expr]) => {
        $crate::fields::accessor!(@signed $field $doc $get, count => count as f64 * ($lsb));
        $($crate::fields::accessor!(@nearest $field $get $set(value) value / ($lsb), 0, true);)?
    };
    (signed_per $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [] [$counts:expr]) => {
        $crate::fields::accessor!(@signed $field $doc $get, count => count as f64 / $counts);
        $($crate::fields::accessor!(@nearest $field $get $set(value) value * $counts, 0, true);)?
    };
    // The other kinds are integers.
    ($whole:ident $field:tt $doc:tt [$get:ident $(/ $set:ident)?] [$type:ty] $scale:tt) => {
        $crate::fields::accessor!(@get $field $doc $get: $type, count => count as $type);
        $($crate::fields::accessor!(@whole $field $get $set: $type);)?
    };
    (@get [$name:ident $store:ident $bits:literal $key:literal] [$($doc:tt)*]
        $get:ident: $type:ty, $count:ident => $value:expr) => {
        $($doc)*
        #[inline]
        pub const fn $get(self) -> $type {
            const AT: usize = <$name as $crate::Describe>::LAYOUT.place($key);
            let $count = $crate::$store::get(&self.0, AT, $bits);
            $value
        }
    };
    // The bit before the value states whether it is populated.
    (@get_populated [$name:ident $store:ident $bits:literal $key:literal] [$($doc:tt)*]
        $get:ident: $type:ty, $count:ident => $value:expr) => {
        $($doc)*
        pub const fn $get(self) -> Option<$type> {
            const AT: usize = <$name as $crate::Describe>::LAYOUT.place($key);
            if $crate::$store::get(&self.0, AT - 1, 1) == 1 {
                let $count = $crate::$store::get(&self.0, AT, $bits);
                Some($value)
            } else {
                None
            }
        }
    };
    (@set_populated [$name:ident $store:ident $bits:literal $key:literal] $get:ident $set:ident) => {
        #[doc = concat!("The same with [`", stringify!($get), "`](Self::", stringify!($get), "); `None` is not populated.")]
        #[must_use]
        pub const fn $set(self, flag: Option<bool>) -> Self {
            const AT: usize = <$name as $crate::Describe>::LAYOUT.place($key);
            let bits = match flag {
                Some(flag) => 0b10 | flag as u64,
                None => 0,
            };
            // The value of an absent extension is already not populated.
            if bits == $crate::$store::get(&self.0, AT - 1, 2) {
                self
            } else {
                Self($crate::$store::set(self.0, AT - 1, 2, bits))
            }
        }
    };
    (@whole_populated [$name:ident $store:ident $bits:literal $key:literal] $get:ident $set:ident: $type:ty) => {
        #[doc = concat!("The same with [`", stringify!($get), "`](Self::", stringify!($get), "), of which `None` is not populated; `None` where ", stringify!($bits), " bits do not hold it.")]
        pub const fn $set(self, number: Option<$type>) -> Option<Self> {
            const AT: usize = <$name as $crate::Describe>::LAYOUT.place($key);
            let bits = match number {
                Some(number) if number as u64 > $crate::bits::mask($bits) => return None,
                Some(number) => 1 << $bits | number as u64,
                None => 0,
            };
            // The value of an absent extension is already not populated.
            Some(if bits == $crate::$store::get(&self.0, AT - 1, $bits + 1) {
                self
            } else {
                Self($crate::$store::set(self.0, AT - 1, $bits + 1, bits))
            })
        }
    };
    (@signed [$name:ident $store:ident $bits:literal $key:literal] $doc:tt
        $get:ident, $count:ident => $value:expr) => {
        $crate::fields::accessor!(@get [$name $store $bits $key] $doc $get: f64, $count => {
            let $count = $crate::bits::signed($count, $bits);
            $value
        });
    };
    (@set [$name:ident $store:ident $bits:literal $key:literal]
        $get:ident $set:ident($value:ident: $type:ty) $count:expr) => {
        #[doc = concat!("The same with [`", stringify!($get), "`](Self::", stringify!($get), "); of a code as much as ", stringify!($bits), " bits hold.")]
        #[must_use]
        pub const fn $set(self, $value: $type) -> Self {
            const AT: usize = <$name as $crate::Describe>::LAYOUT.place($key);
            Self($crate::$store::set(self.0, AT, $bits, $count))
        }
    };
    (@whole [$name:ident $store:ident $bits:literal $key:literal] $get:ident $set:ident: $type:ty) => {
        #[doc = concat!("The same with [`", stringify!($get), "`](Self::", stringify!($get), "); `None` where ", stringify!($bits), " bits do not hold it.")]
        pub const fn $set(self, number: $type) -> Option<Self> {
            const AT: usize = <$name as $crate::Describe>::LAYOUT.place($key);
            if number as u64 <= $crate::bits::mask($bits) {
                Some(Self($crate::$store::set(self.0, AT, $bits, number as u64)))
            } else {
                None
            }
        }
    };
    (@nearest [$name:ident $store:ident $bits:literal $key:literal]
        $get:ident $set:ident($value:ident) $count:expr, $more:literal, $signed:literal) => {
        #[doc = concat!("The same with the count nearest to this [`", stringify!($get), "`](Self::", stringify!($get), "); `None` out of range.")]
        pub fn $set(self, $value: f64) -> Option<Self> {
            const AT: usize = <$name as $crate::Describe>::LAYOUT.place($key);
            let count = $crate::bits::nearest_count($count, $bits + $more, $signed)?;
            Some(Self($crate::$store::set(self.0, AT, $bits, count)))
        }
    };
}

/// The codes of a field. Undefined codes are kept. With `all`, the table defines every code that the bits can hold.
macro_rules! codes {
    ($(#[$meta:meta])* pub enum $name:ident { $($(#[$doc:meta])* $code:ident = $value:literal,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum $name {
            $(#[doc = concat!(stringify!($value), ":")] $(#[$doc])* $code,)*
            /// A code that the edition does not define.
            Other(u8),
        }

        impl $name {
            /// The value of a code.
            pub const fn from_code(code: u8) -> Self {
                match code {
                    $($value => Self::$code,)*
                    other => Self::Other(other),
                }
            }

            /// The code.
            pub const fn code(self) -> u8 {
                match self {
                    $(Self::$code => $value,)*
                    Self::Other(other) => other,
                }
            }
        }
    };
    ($(#[$meta:meta])* all pub enum $name:ident { $($(#[$doc:meta])* $code:ident,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name {
            $($(#[$doc])* $code,)*
        }

        impl $name {
            const ALL: &'static [Self] = &[$(Self::$code,)*];

            /// The value of the lowest bits of a code.
            pub const fn from_code(code: u8) -> Self {
                const { assert!(Self::ALL.len().is_power_of_two()) }
                Self::ALL[code as usize % Self::ALL.len()]
            }

            /// The code.
            pub const fn code(self) -> u8 {
                self as u8
            }
        }
    };
}

pub(crate) use {accessor, accessors, codes, fields, kind};
