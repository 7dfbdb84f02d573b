//! The columns of a record, and the macro by which a signal is declared once.

use std::collections::TryReserveError;

use crate::control::{Channel, Width};

/// A recorded signal with its values, row after row.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// What it is.
    pub channel: Channel,
    /// Its values, as many per row as its [width](Channel::width) says.
    pub values: Vec<f64>,
}

impl Column {
    /// An empty column with room for `rows` rows.
    pub(super) fn with_room(
        channel: Channel,
        joints: usize,
        rows: usize,
    ) -> Result<Self, TryReserveError> {
        let values = room(rows.saturating_mul(channel.width.of(joints)))?;
        Ok(Self { channel, values })
    }
}

/// A row of a signal: one number, or one per joint.
pub(super) trait Cell: Copy {
    const WIDTH: Width;

    fn flat(rows: &[Self]) -> &[f64];
    fn into_flat(rows: Vec<Self>) -> Vec<f64>;
}

impl Cell for f64 {
    const WIDTH: Width = Width::One;

    fn flat(rows: &[Self]) -> &[f64] {
        rows
    }

    fn into_flat(rows: Vec<Self>) -> Vec<f64> {
        rows
    }
}

impl<const N: usize> Cell for [f64; N] {
    const WIDTH: Width = Width::Joints;

    fn flat(rows: &[Self]) -> &[f64] {
        rows.as_flattened()
    }

    fn into_flat(rows: Vec<Self>) -> Vec<f64> {
        rows.into_flattened()
    }
}

/// Room for so many entries.
pub(super) fn room<T>(rows: usize) -> Result<Vec<T>, TryReserveError> {
    let mut column = Vec::new();
    column.try_reserve_exact(rows)?;
    Ok(column)
}

/// Declares the signals of a record, group by group, and with them the record.
///
/// A group has the [`Record`](super::Record) that it enters, and the function that adds a row of
/// it, from its arguments. A signal is `field: cell, "unit", "doc" = value;` with a cell of `f64`
/// or `[f64; N]`; its name is that of the field, unless `as "name"` says another.
macro_rules! record {
    (
        $(#[$meta:meta])*
        $vis:vis struct $record:ident<const $n:ident: usize>;
        $(
            $(#[$push_meta:meta])*
            in $kind:expr, fn $push:ident($($arg:ident: $type:ty),*) {
                $(
                    $field:ident $(as $name:literal)?:
                    $cell:ty, $unit:literal, $doc:literal = $value:expr;
                )*
            }
        )*
        also {
            $(
                $(#[$other_meta:meta])*
                $other:ident: $other_type:ty = $empty:expr;
            )*
        }
    ) => {
        $(#[$meta])*
        $vis struct $record<const $n: usize> {
            $($(
                #[doc = concat!($doc, r" \[", $unit, r"\].")]
                pub $field: Vec<$cell>,
            )*)*
            /// Signals that the compensator adds, as it declares them.
            pub own: Vec<Column>,
            $(
                $(#[$other_meta])*
                pub $other: $other_type,
            )*
        }

        impl<const $n: usize> $record<$n> {
            /// The signals of every record, in their order, each with the records that it enters.
            const TABLE: &'static [(Record, Channel)] = &[
                $($((
                    $kind,
                    Channel {
                        name: record!(@name $field $($name)?),
                        unit: $unit,
                        width: <$cell as Cell>::WIDTH,
                        doc: $doc,
                    },
                ),)*)*
            ];

            /// An empty record with room for `rows` rows, also of the `own` signals of others.
            fn with_room(
                rows: usize,
                record: Record,
                own: &[Channel],
            ) -> Result<Self, TryReserveError> {
                let own_rows = if record.takes(Record::All) { rows } else { 0 };
                let own = own.iter().map(|&channel| Column::with_room(channel, $n, own_rows));
                Ok(Self {
                    $($( $field: room(if record.takes($kind) { rows } else { 0 })?, )*)*
                    own: own.collect::<Result<_, _>>()?,
                    $( $other: $empty, )*
                })
            }

            $(
                $(#[$push_meta])*
                #[inline]
                pub(super) fn $push(&mut self, $($arg: $type),*) {
                    $( self.$field.push($value); )*
                }
            )*

            /// The values of the signal of this name, row after row; `None` if there is none.
            pub fn values(&self, name: &str) -> Option<&[f64]> {
                let own = self.own.iter().find(|column| column.channel.name == name);
                match name {
                    $($( record!(@name $field $($name)?) => Some(Cell::flat(&self.$field)), )*)*
                    _ => own.map(|column| &column.values[..]),
                }
            }

            /// All columns, those of [`channels`](Self::channels) first.
            pub fn into_columns(self) -> Vec<Column> {
                let values = [ $($( Cell::into_flat(self.$field), )*)* ];
                let channels = Self::channels().copied();
                let common = channels.zip(values);
                let common = common.map(|(channel, values)| Column { channel, values });
                common.chain(self.own).collect()
            }
        }
    };
    (@name $field:ident) => { stringify!($field) };
    (@name $field:ident $name:literal) => { $name };
}

pub(super) use record;
