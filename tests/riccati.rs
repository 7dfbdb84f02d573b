use nalgebra::{SMatrix};
use steadyarm::riccati::*;
#[test]
fn probe() {
    let a = SMatrix::<f64,2,2>::new(0.0, 1.0, -8.0, -5.5);
    let b = SMatrix::<f64,2,1>::new(0.0, 1.0);
    let q = SMatrix::<f64, 2, 2>::identity() * 10.0;
    println!("{:?}", bounded_real(&a, &b, &q, 1.0));
    println!("{:?}", joint(8.0, 5.5, 10.0, 10.0, 1.0));
    println!("{:?} {:?}", gamma_opt(&a, &b, &q), joint_gamma_opt(8.0, 5.5, 10.0, 10.0));
    for x in [26.49780684, 26.4978068488, 26.4978069] {
        println!("{:?}", bounded_real(&a, &b, &(SMatrix::<f64, 2, 2>::identity() * x), 1.0));
        println!("{:?}", joint(8.0, 5.5, x, x, 1.0));
    }
}
