//! `docs/configuration.md` is the table of the code.

use shared_control::params::Params;
use shared_control::params::table::Field;

#[test]
fn the_page_has_every_parameter_as_it_is() {
    let rows = Field::ALL.map(|field| {
        let (row, default) = (field.row(), field.row().allowed.number(Params::DEFAULT.get(field)));
        let unit = if row.unit.is_empty() { "-" } else { row.unit };
        format!("| `{}` | {} | {default} | {unit} | {} | {} |\n", row.name, row.allowed, row.counts, row.meaning)
    });
    let table = rows.concat();
    let page = include_str!("../../docs/configuration.md");
    assert!(page.contains(&table), "the table of docs/configuration.md should be:\n{table}");
}
