extends Node3D
# Presses the tip, lets go after a second, and prints how the tongue moved. `-- --check` ends the run.

var frames := 0


func _ready() -> void:
	print($Body.probes())
	$Body.push(Vector3(0.03569, 0.0025, 0.0008), Vector3(0, 0, -0.1))


func _physics_process(_delta: float) -> void:
	frames += 1
	if frames == 60:
		print("under the finger: ", $Body.displacement(Vector3(0.03569, 0.0025, 0.0008)).z, " m")
		$Body.clear()
	if frames == 90 and "--check" in OS.get_cmdline_user_args():
		get_tree().quit(0 if $Body.mesh.get_surface_count() == 1 else 1)
