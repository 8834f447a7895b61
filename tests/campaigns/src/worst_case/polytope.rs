//! Convex polytopes of few dimensions, split by half-spaces.
//!
//! A polytope is its vertices, each with the set of facets that it lies on. Two vertices are the ends of an edge if the
//! facets that they share lie together at no third vertex; a plane meets the edges whose ends lie on different sides of it. (The
//! double description method: Motzkin et al. 1953; Fukuda and Prodon, *Double description method revisited*, 1996.)

/// gradient' x + constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Affine<const D: usize> {
    /// Per unit of each parameter.
    pub gradient: [f64; D],
    /// At the origin.
    pub constant: f64,
}

impl<const D: usize> Affine<D> {
    /// The same everywhere.
    pub fn constant(constant: f64) -> Self {
        Self { gradient: [0.0; D], constant }
    }

    /// Its value at a point.
    pub fn at(&self, point: &[f64; D]) -> f64 {
        self.gradient.iter().zip(point).fold(self.constant, |sum, (gradient, value)| sum + gradient * value)
    }

    /// Adds `factor` times another one.
    pub fn add(&mut self, factor: f64, other: &Self) {
        for (gradient, more) in self.gradient.iter_mut().zip(&other.gradient) {
            *gradient += factor * more;
        }
        self.constant += factor * other.constant;
    }
}

/// Facets as bits.
type Facets = u128;

#[derive(Debug, Clone, Copy)]
struct Vertex<const D: usize> {
    at: [f64; D],
    facets: Facets,
}

/// A bounded polytope with inner points.
#[derive(Debug, Clone)]
pub struct Polytope<const D: usize> {
    vertices: Vec<Vertex<D>>,
    /// In use.
    facets: Facets,
}

/// What lies on either side of a plane.
#[derive(Debug, Clone)]
pub struct Sides<const D: usize> {
    /// Where the function is negative.
    pub below: Option<Polytope<D>>,
    /// Where it is positive.
    pub above: Option<Polytope<D>>,
    /// The plane cuts off less than [`SLIVER`], which is left with the other side.
    pub has_sliver: bool,
}

/// What a plane cuts off is a part of its own if it reaches farther from the plane than this; vertices nearer than this
/// lie on the plane. The parameters are of the size of 1, and single precision has 1e-7 there.
pub const SLIVER: f64 = 1e-11;

impl<const D: usize> Polytope<D> {
    /// All points from `low` to `high`.
    pub fn cuboid(low: [f64; D], high: [f64; D]) -> Self {
        let corner = |bits: usize| {
            let is_high = |axis: usize| bits >> axis & 1 == 1;
            Vertex {
                at: std::array::from_fn(|axis| if is_high(axis) { high[axis] } else { low[axis] }),
                facets: (0..D).map(|axis| 1 << (2 * axis + usize::from(is_high(axis)))).sum(),
            }
        };
        Self { vertices: (0..1 << D).map(corner).collect(), facets: (1 << (2 * D)) - 1 }
    }

    /// Splits it where `function` is 0.
    ///
    /// # Panics
    /// If a part would have more than 128 facets.
    pub fn split(self, function: &Affine<D>) -> Sides<D> {
        let length = function.gradient.iter().map(|gradient| gradient * gradient).sum::<f64>().sqrt();
        let scale = if length > 0.0 { 1.0 / length } else { 1.0 };
        let distances: Vec<f64> = self.vertices.iter().map(|vertex| scale * function.at(&vertex.at)).collect();
        let lowest = distances.iter().copied().fold(f64::INFINITY, f64::min);
        let highest = distances.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if highest <= SLIVER && -lowest >= highest {
            return Sides { below: Some(self), above: None, has_sliver: highest > 0.0 };
        }
        if lowest >= -SLIVER {
            return Sides { below: None, above: Some(self), has_sliver: lowest < 0.0 };
        }
        let plane = 1 << (!self.facets).trailing_zeros();
        assert!(plane != 0, "a polytope of more than 128 facets");
        let cut = self.cut_edges(&distances, plane);
        let side = |sign: f64| {
            let kept = self.vertices.iter().zip(&distances).filter(|(_, distance)| sign * **distance > -SLIVER);
            let on_plane = |distance: f64| if distance.abs() <= SLIVER { plane } else { 0 };
            let kept = kept.map(|(vertex, distance)| Vertex { facets: vertex.facets | on_plane(*distance), ..*vertex });
            Self { vertices: kept.chain(cut.iter().copied()).collect(), facets: self.facets | plane }
                .without_loose_facets()
        };
        Sides { below: Some(side(-1.0)), above: Some(side(1.0)), has_sliver: false }
    }

    /// The points in which the edges meet the plane.
    fn cut_edges(&self, distances: &[f64], plane: Facets) -> Vec<Vertex<D>> {
        let mut cut = Vec::new();
        let on = |sign: f64| (0..distances.len()).filter(move |index| sign * distances[*index] > SLIVER);
        for high in on(1.0) {
            for low in on(-1.0) {
                let (from, to) = (&self.vertices[low], &self.vertices[high]);
                let shared = from.facets & to.facets;
                if self.is_edge(low, high, shared) {
                    let share = distances[low] / (distances[low] - distances[high]);
                    let at = std::array::from_fn(|axis| from.at[axis] + share * (to.at[axis] - from.at[axis]));
                    cut.push(Vertex { at, facets: shared | plane });
                }
            }
        }
        cut
    }

    fn is_edge(&self, one: usize, other: usize, shared: Facets) -> bool {
        let holds_all =
            |(index, vertex): (usize, &Vertex<D>)| index != one && index != other && vertex.facets & shared == shared;
        shared.count_ones() as usize + 1 >= D && !self.vertices.iter().enumerate().any(holds_all)
    }

    /// Forgets the planes that have too few vertices to be a facet.
    fn without_loose_facets(mut self) -> Self {
        let mut rest = self.facets;
        while rest != 0 {
            let facet = rest & rest.wrapping_neg();
            rest ^= facet;
            if self.vertices.iter().filter(|vertex| vertex.facets & facet != 0).count() < D {
                self.facets ^= facet;
            }
        }
        for vertex in &mut self.vertices {
            vertex.facets &= self.facets;
        }
        self
    }

    /// The mean of its vertices.
    pub fn center(&self) -> [f64; D] {
        self.mean(|_| 1.0)
    }

    /// The mean of its vertices, each with the weight of its number, above 0: an inner point.
    pub fn mean(&self, mut weight: impl FnMut(usize) -> f64) -> [f64; D] {
        let (mut sum, mut point) = (0.0, [0.0; D]);
        for (index, vertex) in self.vertices.iter().enumerate() {
            let weight = weight(index);
            sum += weight;
            for (value, at) in point.iter_mut().zip(&vertex.at) {
                *value += weight * at;
            }
        }
        point.map(|value| value / sum)
    }

    /// Its volume: the sum over simplices that share a vertex (Cohen and Hickey, *Two algorithms for determining volumes of
    /// convex polyhedra*, J. ACM 26, 1979).
    pub fn volume(&self) -> f64 {
        let all: Vec<usize> = (0..self.vertices.len()).collect();
        let factorial: f64 = (1..=D).map(|factor| factor as f64).product();
        self.simplices(&all, &mut Vec::with_capacity(D + 1)) / factorial
    }

    /// The sum of |det| of the simplices of `face` with the corners `apexes`.
    fn simplices(&self, face: &[usize], apexes: &mut Vec<usize>) -> f64 {
        let Some((first, others)) = face.split_first() else { return 0.0 };
        if apexes.len() == D {
            let corner = &self.vertices[*first].at;
            let edges: [[f64; D]; D] = std::array::from_fn(|row| {
                std::array::from_fn(|axis| self.vertices[apexes[row]].at[axis] - corner[axis])
            });
            return determinant(edges).abs();
        }
        let common = others.iter().fold(self.vertices[*first].facets, |all, index| all & self.vertices[*index].facets);
        let mut rest = self.facets & !common & !self.vertices[*first].facets;
        let (mut sum, mut seen) = (0.0, Vec::new());
        apexes.push(*first);
        while rest != 0 {
            let facet = rest & rest.wrapping_neg();
            rest ^= facet;
            let side: Vec<usize> =
                others.iter().copied().filter(|index| self.vertices[*index].facets & facet != 0).collect();
            if side.len() + apexes.len() > D && !seen.contains(&side) {
                sum += self.simplices(&side, apexes);
                seen.push(side);
            }
        }
        apexes.pop();
        sum
    }
}

/// By elimination with the largest pivots.
fn determinant<const D: usize>(mut rows: [[f64; D]; D]) -> f64 {
    let mut product = 1.0;
    for column in 0..D {
        let largest = (column..D).max_by(|one, other| rows[*one][column].abs().total_cmp(&rows[*other][column].abs()));
        let pivot = rows[largest.unwrap_or(column)];
        if pivot[column] == 0.0 {
            return 0.0;
        }
        rows.swap(column, largest.unwrap_or(column));
        product *= pivot[column];
        for row in &mut rows[column + 1..] {
            let factor = row[column] / pivot[column];
            for (entry, value) in row.iter_mut().zip(&pivot) {
                *entry -= factor * value;
            }
        }
    }
    product
}
