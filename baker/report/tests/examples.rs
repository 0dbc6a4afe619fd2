//! The examples do what they say.

#[allow(dead_code)]
#[path = "../examples/report.rs"]
mod report;

#[test]
fn the_report_of_a_sphere_passes() {
    let sphere = report::sphere(32).unwrap();
    let diagnosis = volmap_bake::mesh::prepare(&mut sphere.mesh.clone(), false).diagnosis;
    assert!(diagnosis.closed && diagnosis.oriented);
    let (text, passed) = report::measure().unwrap();
    assert!(passed && text.contains("the limit is 2 %: passed"), "{text}");
}
