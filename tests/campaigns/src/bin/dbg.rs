fn main() {
    let a: Vec<f64> = std::env::args().skip(1).map(|x| x.parse().unwrap()).collect();
    campaigns::attitude_error::debug(a[0] as usize, a[1], a[2], a[3] as u64);
}
