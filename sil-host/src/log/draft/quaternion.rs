//! Four columns that are a quaternion: names that end in its letters or numbers, values of unit norm.

use super::super::messages::Table;

/// Words before its letters and numbers.
const STEMS: [&str; 7] = ["q", "quat", "quaternion", "orientation", "attitude", "att", "rotation"];
/// So many of the rows must have unit norm, to this accuracy.
const OF_ROWS: f64 = 0.99;
const NORM_ERROR: f64 = 0.02;

/// A table's quaternion.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Quaternion {
    /// Columns of w, x, y, z.
    pub(super) columns: [String; 4],
    /// True where the names have no letters, so that the order is a guess.
    pub(super) is_order_guessed: bool,
}

/// The first in the order of the columns.
pub(super) fn quaternion(table: &Table) -> Option<Quaternion> {
    let named: Vec<(&str, String, char)> = table.fields().filter_map(parted).collect();
    let of = |stem: &str, ends: [char; 4]| -> Option<[String; 4]> {
        let column = |end: char| named.iter().find(|(_, own, letter)| own == stem && *letter == end);
        let [w, x, y, z] = ends.map(|end| column(end).map(|(name, ..)| (*name).to_owned()));
        Some([w?, x?, y?, z?])
    };
    let orders = [(['w', 'x', 'y', 'z'], false), (['0', '1', '2', '3'], true), (['1', '2', '3', '4'], true)];
    let mut all = named.iter().flat_map(|(_, stem, _)| {
        orders
            .into_iter()
            .filter_map(|(ends, is_order_guessed)| Some(Quaternion { columns: of(stem, ends)?, is_order_guessed }))
    });
    all.find(|found| is_unit(found, table))
}

/// A name's stem, without what separates, and its last letter or number; none of other names.
fn parted(name: &str) -> Option<(&str, String, char)> {
    let stem = name.trim_end_matches([']', ')']);
    let end = stem.chars().last()?.to_ascii_lowercase();
    let stem = stem[..stem.len() - end.len_utf8()].to_lowercase();
    let last = stem.rsplit(|c: char| !c.is_alphanumeric()).find(|word| !word.is_empty())?;
    (STEMS.contains(&last) && "wxyz01234".contains(end)).then_some((name, stem, end))
}

fn is_unit(found: &Quaternion, table: &Table) -> bool {
    let columns: Vec<&[f64]> = found.columns.iter().filter_map(|name| table.column(name)).collect();
    let norm = |row: usize| columns.iter().map(|column| column[row] * column[row]).sum::<f64>().sqrt();
    let is_near = |row: &usize| (norm(*row) - 1.0).abs() < NORM_ERROR;
    let rows = table.rows();
    columns.len() == 4 && rows > 0 && (0..rows).filter(is_near).count() as f64 >= OF_ROWS * rows as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(names: [&str; 5], norm: f64) -> Table {
        let mut table = Table::with_fields(names.iter().map(|name| (*name).to_owned()));
        for row in 0..100 {
            let half = 0.01 * f64::from(row);
            table.push([f64::from(row), norm * libm::cos(half), norm * libm::sin(half), 0.0, 0.0]);
        }
        table
    }

    #[test]
    fn names_of_many_loggers_are_understood_and_held_against_the_norm() {
        for (names, is_order_guessed) in [
            (["t", "q_w", "q_x", "q_y", "q_z"], false),
            (["t", "qw", "qx", "qy", "qz"], false),
            (["t", "pose.orientation.w", "pose.orientation.x", "pose.orientation.y", "pose.orientation.z"], false),
            (["t", "q[0]", "q[1]", "q[2]", "q[3]"], true),
            (["t", "Q1", "Q2", "Q3", "Q4"], true),
        ] {
            let found = quaternion(&table(names, 1.0)).unwrap_or_else(|| panic!("{names:?}"));
            assert_eq!(
                (found.columns.each_ref().map(String::as_str), found.is_order_guessed),
                ([names[1], names[2], names[3], names[4]], is_order_guessed)
            );
        }
        assert_eq!(quaternion(&table(["t", "q_w", "q_x", "q_y", "q_z"], 1.1)), None);
        for names in
            [["t", "q", "p", "r", "w"], ["t", "acc_w", "acc_x", "acc_y", "acc_z"], ["t", "m0", "m1", "m2", "m3"]]
        {
            assert_eq!(quaternion(&table(names, 1.0)), None, "{names:?}");
        }
    }
}
