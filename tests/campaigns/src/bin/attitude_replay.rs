//! The estimator on measured flights, as the table of docs/attitude-error.md:
//! `cargo run --release -p campaigns --bin attitude_replay`, with the logs in `$SIL_DATA`.

fn main() {
    print!("{}", campaigns::attitude_replay::table(&campaigns::attitude_replay::replayed()));
}
