//! Typed access to the tables of a TOML document, with the position of every fault.
//!
//! The tables are read by hand from the `toml` crate's tree, in which every key and value has its span, rather than by
//! `#[derive(Deserialize)]`. Serde words its errors itself, and loses the position inside tagged and untagged enums,
//! such as a material given by name or inline.

use super::error::{Fault, quote, short, suggestion};
use scene::Vec3;
use scene::check::LIMIT;
use std::fmt;
use toml::de::{DeTable, DeValue};

/// The part of the file that a key belongs to, for messages.
#[derive(Clone, Copy)]
pub(super) enum Subject<'a> {
    /// A file other than a scene, or a part of it, with its name for messages.
    Other(&'a str),
    Scene,
    Camera,
    Settings,
    Material(&'a str),
    /// A sphere: its index in the file, and its name.
    Sphere(usize, Option<&'a str>),
    /// The inline material of a sphere.
    MaterialOf(usize, Option<&'a str>),
}

impl fmt::Display for Subject<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Other(name) => write!(f, "{name}"),
            Self::Scene => write!(f, "the scene"),
            Self::Camera => write!(f, "[camera]"),
            Self::Settings => write!(f, "[settings]"),
            Self::Material(name) => write!(f, "material {}", quote(name)),
            Self::Sphere(_, Some(name)) => write!(f, "sphere {}", quote(name)),
            Self::Sphere(i, None) => write!(f, "sphere {}", i + 1),
            Self::MaterialOf(i, name) => write!(f, "the material of {}", Subject::Sphere(i, name)),
        }
    }
}

/// A table that has only known keys.
#[derive(Clone, Copy)]
pub struct Section<'a> {
    pub(super) subject: Subject<'a>,
    /// Byte offset of its beginning, where missing keys are reported.
    pub(super) at: usize,
    table: &'a DeTable<'a>,
}

impl<'a> Section<'a> {
    /// Checks that `table` has no keys other than `keys`.
    pub(super) fn new(
        subject: Subject<'a>,
        at: usize,
        table: &'a DeTable<'a>,
        keys: &[&str],
    ) -> Result<Self, Fault> {
        let unknown = table.keys().filter(|k| !keys.contains(&k.get_ref().as_ref()));
        match unknown.min_by_key(|k| k.span().start) {
            None => Ok(Self { subject, at, table }),
            Some(key) => {
                let (name, keys_are) = (quote(key.get_ref()), keys.join(", "));
                let guess = suggestion(key.get_ref(), keys.iter().copied());
                let message = format!("unknown key {name} in {subject}{guess}; the keys are {keys_are}");
                Err(Fault::new(key.span().start, message))
            }
        }
    }

    /// The field `key`, if present.
    pub fn get(&self, key: &'static str) -> Option<Field<'a>> {
        let value = self.table.get(key)?;
        Some(Field { subject: self.subject, key, at: value.span().start, value: value.get_ref() })
    }

    /// Where the key `key` stands, if it is present.
    pub(super) fn key_at(&self, key: &str) -> Option<usize> {
        self.table.get_key_value(key).map(|(key, _)| key.span().start)
    }

    /// The field `key`, which must be present; the error message shows `example`.
    pub(super) fn require(&self, key: &'static str, example: &str) -> Result<Field<'a>, Fault> {
        let missing = || Fault::new(self.at, format!("{} has no {key}; add {example}", self.subject));
        self.get(key).ok_or_else(missing)
    }

    /// The field `key` converted by `read`, or `default` if it is absent.
    pub(super) fn or<T>(
        &self,
        key: &'static str,
        default: T,
        read: impl FnOnce(Field<'a>) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        self.get(key).map_or(Ok(default), read)
    }
}

/// A value with its key and the section that it belongs to.
#[derive(Clone, Copy)]
pub struct Field<'a> {
    pub(super) subject: Subject<'a>,
    pub(super) key: &'static str,
    /// Byte offset of the value.
    pub(super) at: usize,
    pub(super) value: &'a DeValue<'a>,
}

/// A number, not yet checked.
#[derive(Clone, Copy)]
pub(super) struct Number<'a> {
    field: Field<'a>,
    /// NaN if the file says so, or if the number is infinite or beyond [`LIMIT`]: comparisons with NaN are false.
    value: f32,
}

impl<'a> Field<'a> {
    /// A fault of this field. The message gives the key and the value as written, then `problem`.
    pub fn fault(&self, problem: impl fmt::Display) -> Fault {
        let written = match self.value {
            DeValue::Integer(v) => format!(" {}", short(&v.to_string())),
            DeValue::Float(v) => format!(" {}", short(v.as_str())),
            DeValue::String(v) => format!(" {}", quote(v)),
            _ => String::new(),
        };
        Fault::new(self.at, format!("{}{written} of {} {problem}", self.key, self.subject))
    }

    /// The value as a table that may have only the keys `keys`; messages call it `name`.
    ///
    /// # Errors
    /// If it is not a table, or has another key.
    pub fn section(&self, name: &'a str, keys: &[&str]) -> Result<Section<'a>, Fault> {
        let table = self.value.as_table().ok_or_else(|| self.wrong_type("a table"))?;
        Section::new(Subject::Other(name), self.at, table, keys)
    }

    /// The value as a number of any size.
    ///
    /// # Errors
    /// If it is not a number.
    pub fn float(&self) -> Result<f64, Fault> {
        float(self.value).ok_or_else(|| self.wrong_type("a number"))
    }

    fn wrong_type(&self, expected: &str) -> Fault {
        Fault::new(
            self.at,
            format!("{} of {} must be {expected}, not {}", self.key, self.subject, type_of(self.value)),
        )
    }

    pub(super) fn number(&self) -> Result<Number<'a>, Fault> {
        let value = self.float()?;
        // Adding zero turns -0, whether written or from underflow, into 0.
        let value = if value.abs() <= LIMIT { value as f32 + 0.0 } else { f32::NAN };
        Ok(Number { field: *self, value })
    }

    /// A whole number from `low` to `high`.
    pub(super) fn whole(&self, low: u64, high: u64) -> Result<u64, Fault> {
        let value = match self.value {
            DeValue::Integer(v) => u64::from_str_radix(v.as_str(), v.radix()).ok(),
            DeValue::Float(_) => None,
            _ => return Err(self.wrong_type("a whole number")),
        };
        value
            .filter(|v| (low..=high).contains(v))
            .ok_or_else(|| self.fault(format_args!("must be a whole number from {low} to {high}")))
    }

    /// The value as true or false.
    ///
    /// # Errors
    /// If it is neither.
    pub(super) fn truth(&self) -> Result<bool, Fault> {
        self.value.as_bool().ok_or_else(|| self.wrong_type("true or false"))
    }

    /// The value as a string.
    ///
    /// # Errors
    /// If it is not a string.
    pub fn text(&self) -> Result<&'a str, Fault> {
        self.value.as_str().ok_or_else(|| self.wrong_type("a string"))
    }

    /// The value as an array of `N` numbers; `what` describes them in messages.
    pub(super) fn numbers<const N: usize>(&self, what: &str) -> Result<[Number<'a>; N], Fault> {
        let Some(array) = self.value.as_array() else {
            return Err(self.wrong_type(&format!("{N} numbers, {what}")));
        };
        if array.len() != N {
            let message = format!(
                "{} of {} has {} elements; it must have {N}, {what}",
                self.key,
                self.subject,
                array.len()
            );
            return Err(Fault::new(self.at, message));
        }
        let mut numbers = [Number { field: *self, value: 0.0 }; N];
        for (number, element) in numbers.iter_mut().zip(array.iter()) {
            let field = Self { at: element.span().start, value: element.get_ref(), ..*self };
            *number = field
                .number()
                .map_err(|fault| Fault { message: format!("each in {}", fault.message), ..fault })?;
        }
        Ok(numbers)
    }

    /// The value as a point or a vector.
    pub(super) fn vector(&self) -> Result<Vec3, Fault> {
        let [x, y, z] = self.numbers("[x, y, z]")?;
        Ok(Vec3::new(x.finite()?, y.finite()?, z.finite()?))
    }

    /// The value as a colour; `check` is applied to each channel.
    pub(super) fn rgb(&self, check: impl Fn(Number) -> Result<f32, Fault>) -> Result<Vec3, Fault> {
        let [r, g, b] = self.numbers("[red, green, blue]")?;
        Ok(Vec3::new(check(r)?, check(g)?, check(b)?))
    }
}

impl Number<'_> {
    /// The number if it is finite and within [`LIMIT`].
    pub(super) fn finite(self) -> Result<f32, Fault> {
        self.check(|v| !v.is_nan(), format_args!("must be a finite number from -{LIMIT:e} to {LIMIT:e}"))
    }

    /// The number if `right` accepts it, else a fault with `problem`. `right` must not accept NaN.
    pub(super) fn check(
        self,
        right: impl FnOnce(f32) -> bool,
        problem: impl fmt::Display,
    ) -> Result<f32, Fault> {
        if right(self.value) { Ok(self.value) } else { Err(self.field.fault(problem)) }
    }
}

/// The type of a value, for messages.
pub(super) fn type_of(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a string",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date or time",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}

/// `value` as a number, infinite if it is too large; `None` if it is not a number.
fn float(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(v) => v.as_str().parse().ok(),
        DeValue::Integer(v) if v.radix() == 10 => v.as_str().parse().ok(),
        DeValue::Integer(v) => {
            Some(u64::from_str_radix(v.as_str(), v.radix()).map_or(f64::INFINITY, |v| v as f64))
        }
        _ => None,
    }
}
