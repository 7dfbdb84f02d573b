//! Order conditions of the tableaus over all rooted trees (Butcher), and the orders that are
//! observed.

use crate::common::{FORMS, adaptive, run};
use steadyarm::fuzzy::Form;
use steadyarm::sim::{DP54, DP54_ERROR, Method, Options, RK4, Run, Tableau, Tolerance, dp54_dense};

/// Sums of a few dozen rounded coefficients of size up to 12.
const CONDITION_TOL: f64 = 1e-14;

/// A rooted tree: the branches at its root.
#[derive(Clone, Debug)]
struct Tree(Vec<Tree>);

impl Tree {
    fn order(&self) -> usize {
        1 + self.0.iter().map(Self::order).sum::<usize>()
    }

    /// γ: the order times the γ of every branch.
    fn density(&self) -> f64 {
        self.order() as f64 * self.0.iter().map(Self::density).product::<f64>()
    }

    /// Φᵢ = Π over the branches Σⱼ aᵢⱼ Φⱼ(branch).
    fn weight<const S: usize>(&self, tableau: &Tableau<S>, i: usize) -> f64 {
        let branch = |tree: &Self| -> f64 {
            (0..S).map(|j| tableau.rows[i][j] * tree.weight(tableau, j)).sum()
        };
        self.0.iter().map(branch).product()
    }

    /// Σ bᵢ Φᵢ, which must be 1/γ.
    fn sum<const S: usize>(&self, tableau: &Tableau<S>, weights: &[f64; S]) -> f64 {
        (0..S).map(|i| weights[i] * self.weight(tableau, i)).sum()
    }
}

/// All rooted trees of an order: multisets of branches, taken in ascending order of their place in
/// a list.
fn trees(order: usize) -> Vec<Tree> {
    let smaller: Vec<Tree> = (1..order).flat_map(trees).collect();
    let mut found = Vec::new();
    grow(&smaller, 0, order - 1, &mut Vec::new(), &mut found);
    found
}

fn grow(
    smaller: &[Tree],
    from: usize,
    left: usize,
    branches: &mut Vec<Tree>,
    found: &mut Vec<Tree>,
) {
    if left == 0 {
        return found.push(Tree(branches.clone()));
    }
    for (k, tree) in smaller.iter().enumerate().skip(from) {
        if tree.order() <= left {
            branches.push(tree.clone());
            grow(smaller, k, left - tree.order(), branches, found);
            branches.pop();
        }
    }
}

/// The largest violation of the conditions of one order; θ is where in the step a dense output is.
fn violation<const S: usize>(
    tableau: &Tableau<S>,
    weights: &[f64; S],
    order: usize,
    theta: f64,
) -> f64 {
    let miss = |tree: &Tree| {
        (tree.sum(tableau, weights) - theta.powi(order as i32) / tree.density()).abs()
    };
    trees(order).iter().map(miss).fold(0.0, f64::max)
}

fn assert_order<const S: usize>(
    tableau: &Tableau<S>,
    weights: &[f64; S],
    order: usize,
    theta: f64,
) {
    for q in 1..=order {
        let miss = violation(tableau, weights, q, theta);
        assert!(miss < CONDITION_TOL, "order {q} at {theta}: {miss:e}");
    }
    let next = violation(tableau, weights, order + 1, theta);
    assert!(next > 1e-6 || theta == 0.0, "order {} too: {next:e}", order + 1);
}

#[test]
fn there_are_as_many_rooted_trees_as_known() {
    assert_eq!([1, 2, 3, 4, 5, 6].map(|order| trees(order).len()), [1, 1, 2, 4, 9, 20]);
}

#[test]
fn rk4_has_order_4() {
    assert_order(&RK4, &RK4.weights, 4, 1.0);
}

#[test]
fn dp54_has_order_5_and_its_embedded_method_order_4() {
    assert_order(&DP54, &DP54.weights, 5, 1.0);
    let mut embedded = DP54.weights;
    embedded.iter_mut().zip(DP54_ERROR).for_each(|(b, error)| *b -= error);
    assert_order(&DP54, &embedded, 4, 1.0);
}

#[test]
fn dense_output_has_order_4_everywhere_and_ends_in_the_step() {
    for k in 1..10 {
        let theta = f64::from(k) / 10.0;
        assert_order(&DP54, &dp54_dense(theta), 4, theta);
    }
    assert_eq!(dp54_dense(0.0), [0.0; 7]);
    for (b, weight) in dp54_dense(1.0).iter().zip(DP54.weights) {
        assert!((b - weight).abs() < CONDITION_TOL);
    }
}

#[test]
fn nodes_are_the_sums_of_their_rows() {
    fn check<const S: usize>(tableau: &Tableau<S>) {
        for (node, row) in tableau.nodes.iter().zip(tableau.rows) {
            assert!((node - row.iter().sum::<f64>()).abs() < CONDITION_TOL);
        }
    }
    check(&RK4);
    check(&DP54);
}

/// 3.2 s of the claimed simulation 3, and the distance of two such runs at their common times.
fn claimed(dt: f64, method: Method) -> Run<2> {
    let options = Options { duration: 3.2, dt, method, q0: [0.3, -0.3], ..Options::default() };
    run(&adaptive(Form::Grid, false, 7.0), &options)
}

fn distance(fine: &Run<2>, coarse: &Run<2>) -> f64 {
    let every = (fine.t.len() - 1) / (coarse.t.len() - 1);
    let mut largest: f64 = 0.0;
    for (k, (q, dq)) in coarse.q.iter().zip(&coarse.dq).enumerate() {
        for n in 0..2 {
            largest = largest.max((q[n] - fine.q[k * every][n]).abs());
            largest = largest.max((dq[n] - fine.dq[k * every][n]).abs());
        }
    }
    largest
}

#[test]
fn rk4_converges_with_order_4() {
    let exact = claimed(0.25e-3, Method::Rk4);
    let errors = [16e-3, 8e-3, 4e-3].map(|dt| distance(&exact, &claimed(dt, Method::Rk4)));
    for pair in errors.windows(2) {
        let slope = (pair[0] / pair[1]).log2();
        assert!((slope - 4.0).abs() < 0.2, "slope {slope}: {errors:?}");
    }
}

/// Both methods, and the dense output between the steps, go to the same motion.
#[test]
fn dp54_error_falls_with_its_tolerance() {
    let exact = claimed(0.25e-3, Method::Rk4);
    let errors = [1e-4, 1e-6, 1e-8, 1e-10].map(|rtol| {
        let tolerance = Tolerance { rtol, atol: rtol };
        distance(&exact, &claimed(1e-3, Method::Dp54(tolerance)))
    });
    for (pair, rtol) in errors.windows(2).zip([1e-4, 1e-6, 1e-8]) {
        assert!(pair[0] < 50.0 * rtol && pair[1] < 0.1 * pair[0], "{errors:?}");
    }
}

#[test]
fn rows_between_the_steps_of_dp54_know_the_weights_as_rows_of_rk4_do() {
    let tolerance = Tolerance { rtol: 1e-10, atol: 1e-12 };
    for form in FORMS {
        let controller = adaptive(form, false, 7.0);
        let options = Options { duration: 5.0, ..Options::default() };
        let fixed = run(&controller, &options);
        let dense = run(&controller, &Options { method: Method::Dp54(tolerance), ..options });
        let largest = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
                / b.iter().copied().fold(0.0, f64::max)
        };
        assert!(largest(&dense.weights_norm, &fixed.weights_norm) < 1e-6, "{form:?}");
        assert!(largest(&dense.v, &fixed.v) < 1e-6, "{form:?}");
    }
}
