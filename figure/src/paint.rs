//! Colours of particles.

use crate::color::{Screen, palette};
use crate::columns::{Column, Columns, unknown};
use crate::rule::{End, Paint, Range, Rule};
use crate::table::Table;
use importers::elements::{Element, element};
use std::collections::{BTreeSet, HashMap};

/// What has no name, or is of no known element.
const NAMELESS: Screen = Screen([160, 160, 160]);

/// Sets the colours of the `chosen` particles, by a rule that has the colour `paint`. Their values make the range of a map.
pub(crate) fn paint(
    table: &Table<'_>,
    rule: &Rule,
    paint: &Paint,
    chosen: &[u32],
    colors: &mut [Screen],
) -> Result<(), String> {
    let particles = table.particles;
    let elements = |of: fn(&Element) -> [u8; 3]| {
        let missing = "the file has no elements; take another colour, such as type or #c0ffee";
        let elements = particles.elements.as_ref().ok_or(missing)?;
        Ok::<_, String>(move |i: usize| element(elements[i]).map_or(NAMELESS, |element| Screen(of(element))))
    };
    let color: Box<dyn Fn(usize) -> Screen + Sync> = match paint {
        Paint::Constant(color) => Box::new(|_| *color),
        Paint::Jmol => Box::new(elements(|element| element.jmol)?),
        Paint::Cpk => Box::new(elements(|element| element.cpk)?),
        Paint::File => {
            let colors = particles.colors.as_ref().ok_or("the file has no colours")?;
            Box::new(|i| Screen::of_values(colors[i]))
        }
        Paint::Column(name) => match table.column(name) {
            None => return Err(unknown(table, name)),
            Some(Column::Text { index, names }) => {
                refuse_map(rule, name)?;
                let used: BTreeSet<u32> = chosen.iter().map(|&i| index(i as usize)).collect();
                let colors = of_names(&names, &used);
                Box::new(move |i| colors.get(&index(i)).copied().unwrap_or(NAMELESS))
            }
            Some(Column::Number(value)) if name == "molecule" => {
                refuse_map(rule, name)?;
                let used: BTreeSet<u64> = chosen.iter().map(|&i| value(i as usize).to_bits()).collect();
                let colors: HashMap<u64, Screen> =
                    used.into_iter().enumerate().map(|(place, bits)| (bits, palette(place))).collect();
                Box::new(move |i| colors[&value(i).to_bits()])
            }
            Some(Column::Number(value)) => {
                let ends = ends(rule.range, chosen, &*value)?;
                let map = rule.map.unwrap_or_default();
                Box::new(move |i| map.at(place(ends, value(i))))
            }
        },
    };
    if let Paint::Column(_) = paint {
    } else if rule.map.is_some() || rule.range.is_some() {
        refuse_map(rule, &paint.to_string())?;
    }
    for i in chosen.iter().map(|&i| i as usize) {
        colors[i] = color(i);
    }
    Ok(())
}

fn refuse_map(rule: &Rule, name: &str) -> Result<(), String> {
    let Rule { map: None, range: None, .. } = rule else {
        return Err(format!("a map and its range are for a column of numbers, and `{name}` is none"));
    };
    Ok(())
}

/// A colour for each of the `used` names, in the order of the names: numbers by their value, before other texts.
fn of_names(names: &[String], used: &BTreeSet<u32>) -> HashMap<u32, Screen> {
    let mut sorted: Vec<(Option<u64>, &str, u32)> = used
        .iter()
        .filter_map(|&i| names.get(i as usize).map(|name| (name.parse().ok(), name.as_str(), i)))
        .collect();
    sorted.sort_unstable_by_key(|&(number, name, _)| (number.is_none(), number, name));
    sorted.into_iter().enumerate().map(|(place, (_, _, i))| (i, palette(place))).collect()
}

/// Where a value is on a map between these ends: 0 to 1, and beyond. A column of one value has the middle of the map.
fn place([low, high]: [f64; 2], v: f64) -> f64 {
    if low < high { (v - low) / (high - low) } else { v - low + 0.5 }
}

/// The values at the ends of a map.
fn ends(
    range: Option<Range>,
    chosen: &[u32],
    value: &(dyn Fn(usize) -> f64 + Sync),
) -> Result<[f64; 2], String> {
    let Range(low, high) = range.unwrap_or(Range(End::Percentile(0.0), End::Percentile(100.0)));
    // Percentiles are of values in their order; ends that are given need none.
    let is_percentile = |end: End| matches!(end, End::Percentile(_));
    let ranked = if is_percentile(low) || is_percentile(high) { chosen } else { &[] };
    let mut values: Vec<f64> = ranked.iter().map(|&i| value(i as usize)).filter(|v| v.is_finite()).collect();
    let mut end = |end: End| match end {
        End::Value(value) => value,
        End::Percentile(_) if values.is_empty() => 0.0, // nothing is coloured by it
        End::Percentile(share) => {
            let place = (share / 100.0 * (values.len() - 1) as f64).round() as usize;
            *values.select_nth_unstable_by(place, f64::total_cmp).1
        }
    };
    let [low, high] = [low, high].map(&mut end);
    if low <= high {
        return Ok([low, high]);
    }
    Err(format!("the range is from {low} down to {high}; the lower end comes first"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_coloured_in_their_own_order() {
        let names = ["10", "b", "2", "a"].map(String::from);
        let colors = of_names(&names, &BTreeSet::from([0, 1, 2, 3]));
        assert_eq!([2, 0, 3, 1].map(|i| colors[&i]), [0, 1, 2, 3].map(palette));
        // What is not there takes no colour.
        let colors = of_names(&names, &BTreeSet::from([1, 2]));
        assert_eq!([2, 1].map(|i| colors[&i]), [0, 1].map(palette));
    }

    #[test]
    fn a_column_of_one_value_has_the_middle_of_the_map() {
        assert_eq!([2.0, 3.0, 4.0, 6.0].map(|v| place([2.0, 4.0], v)), [0.0, 0.5, 1.0, 2.0]);
        assert_eq!([2.5, 3.0, 3.5].map(|v| place([3.0, 3.0], v)), [0.0, 0.5, 1.0]);
    }

    #[test]
    fn ranges_are_of_finite_values() {
        let values = [3.0, f64::NAN, -1.0, f64::INFINITY, 1.0, 2.0, 0.0];
        let chosen: Vec<u32> = (0..values.len() as u32).collect();
        let ends = |range: Option<&str>| {
            let mut rule = Rule::default();
            if let Some(range) = range {
                rule.set("range", range).unwrap();
            }
            ends(rule.range, &chosen, &|i| values[i])
        };
        assert_eq!(ends(None), Ok([-1.0, 3.0]));
        assert_eq!(ends(Some("25%..75%")), Ok([0.0, 2.0]));
        assert_eq!(ends(Some("-5..50%")), Ok([-5.0, 1.0]));
        assert!(ends(Some("9..50%")).unwrap_err().contains("from 9 down to 1"));
    }
}
