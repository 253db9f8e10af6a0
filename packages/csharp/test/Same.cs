// The march of same.c in C#: each number as its bits. check compares what the two print.

using System;
using System.IO;
using System.Runtime.InteropServices;
using Vademecum;

internal static class Same
{
    private static void Bits(string what, params double[] values)
    {
        Console.Write(what);
        foreach (var value in values)
        {
            Console.Write(" {0:x16}", BitConverter.DoubleToInt64Bits(value));
        }
        Console.WriteLine();
    }

    private static void Bits(string what, Vector v) => Bits(what, v.X, v.Y, v.Z);

    private static void Bits(string what, Tensor t) => Bits(what, t.XX, t.YY, t.ZZ, t.XY, t.YZ, t.ZX);

    private static void Bits(string what, Wrench w) =>
        Bits(what, w.Force.X, w.Force.Y, w.Force.Z, w.Moment.X, w.Moment.Y, w.Moment.Z);

    private static void Hashed(string what, byte[] bytes)
    {
        ulong hash = 14695981039346656037;
        foreach (var one in bytes)
        {
            hash = unchecked((hash ^ one) * 1099511628211);
        }
        Console.WriteLine("{0} {1} {2:x16}", what, bytes.Length, hash);
    }

    private static bool Try(string what, Action call)
    {
        try
        {
            call();
            return true;
        }
        catch (VademecumException refusal)
        {
            Console.WriteLine("{0} refused {1}: {2}", what, (int)refusal.Status, refusal.Message);
            return false;
        }
    }

    private static void ReadAll(Body body, Place place)
    {
        var counts = body.Counts;
        Try("point", () => Bits("point", body.Point(ref place)));
        Try("speed", () => Bits("speed", body.Point(ref place, Field.Velocity)));
        Try("node", () => Bits("node", body.Node((int)counts.Nodes - 1)));
        Try("energy", () => Bits("energy", body.Energy()));
        for (int i = 0; i < counts.Probes; i++)
        {
            Try("probe", () => Bits("probe", body.Probe(i)));
        }
        for (int i = 0; i < 2; i++)
        {
            Try("reaction", () => Bits("reaction", body.Reaction(i)));
        }
        Console.WriteLine("stress points {0}", body.StressPoints);
        for (int i = 0; i < body.StressPoints; i++)
        {
            Try("where", () =>
            {
                int node, region;
                body.StressPoint(i, out node, out region);
                Console.WriteLine("where {0} {1}", node, region);
            });
            Try("stress", () => Bits("stress", body.Stress(i)));
            Try("strain", () => Bits("strain", body.Strain(i)));
            Try("mises", () => Bits("mises", body.VonMises(i)));
        }
        Try("surface", () =>
        {
            var values = new double[3 * counts.SurfaceNodes];
            if (body.Options.Precision == Precision.Double)
            {
                body.Surface(values);
            }
            else
            {
                var single = new float[values.Length];
                body.Surface(single);
                Array.Copy(single, values, single.Length);
            }
            Bits("surface", values);
        });
        Try("coordinates", () =>
        {
            double[] zeta = new double[counts.Modes], rates = new double[counts.Modes], both = new double[2 * counts.Modes];
            body.Coordinates(zeta, rates);
            zeta.CopyTo(both, 0);
            rates.CopyTo(both, zeta.Length);
            Bits("coordinates", both);
        });
        Try("save", () => Hashed("save", body.Save()));
    }

    private static void March(string path, Precision precision)
    {
        Vector push = new Vector(1.0, -2.0, 3.0), end = new Vector(-0.5, 0.25, 0.125);
        Console.WriteLine("== {0} {1}", Path.GetFileName(path), (int)precision);
        var options = BodyOptions.Default;
        options.Precision = precision;
        options.Places = 2;
        options.Flight = 0;
        using (var file = BodyFile.Open(path))
        {
            Body body = null;
            if (!Try("measure", () => body = file.Bind(options)))
            {
                return;
            }
            // The body keeps the bytes.
            file.Dispose();
            using (body)
            {
                var n = body.Counts;
                Console.WriteLine("needs {0} {1} {2} {3} {4} {5} {6} {7} {8} {9}", n.Bytes, n.Modes, n.Nodes, n.SurfaceNodes,
                    n.LoadNodes, n.Triangles, n.LoadTriangles, n.Probes, n.Patterns, n.Parameters);
                Bits("step", n.TimeStep);
                var places = new Place[2];
                for (int i = 0; i < 2; i++)
                {
                    if (!Try("place", () => places[i] = body.AtNode(1 + i)))
                    {
                        return;
                    }
                }
                Bits("place", places[1].Position);
                Try("push", () => body.Push(ref places[0], push));
                Try("step", () => body.Step(20));
                Try("ramp", () => body.PushRamp(ref places[1], push, end));
                Try("pattern", () => body.PushPattern(0, 0.5));
                Try("compliance", () => Bits("compliance", body.Compliance(places)));
                Try("free", () =>
                {
                    var u = body.FreeMotion(places);
                    Bits("free", u[0].X, u[0].Y, u[0].Z, u[1].X, u[1].Y, u[1].Z);
                });
                Try("step", () => body.Step());
                ReadAll(body, places[0]);
                Try("clear", () => body.Clear());
                for (uint i = 0; i < n.Parameters; i++)
                {
                    Parameter found = default(Parameter);
                    Try("parameter", () => found = body.Parameter((int)i));
                    Console.WriteLine("parameter {0}", found.Logarithmic ? 1 : 0);
                    Bits("range", found.Lower, found.Upper, found.Nominal, found.Value);
                    Try("set", () => body.SetParameters(new[] { i }, new[] { found.Lower + 0.375 * (found.Upper - found.Lower) }));
                }
                Try("nowhere", () => body.PushPattern(77, 1.0));
                Try("push", () => body.Push(ref places[1], push));
                Try("step", () => body.Step(10));
                ReadAll(body, places[1]);
            }
        }
    }

    private static Body Member(string path)
    {
        var options = BodyOptions.Default;
        options.Contacts = 128;
        options.TimeStep = 1e-3;
        using (var file = BodyFile.Open(path))
        {
            return file.Bind(options);
        }
    }

    private static void Together(string cube, string ground)
    {
        Console.WriteLine("== world");
        using (Body falling = Member(cube), standing = Member(ground))
        {
            var motion = falling.Motion;
            motion.Position.X += 0.04;
            motion.Position.Y += 0.04;
            motion.Position.Z += 0.085;
            falling.Motion = motion;
            var rigid = new Member
            {
                Nodes = new[] { 0, 0, 0, 0.02, 0, 0, 0, 0.02, 0, 0, 0, 0.02 },
                Triangles = new uint[] { 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3 },
                Mass = new RigidBody
                {
                    Mass = 0.01,
                    Centre = new Vector(0.005, 0.005, 0.005),
                    Moments = new Vector(1e-6, 1e-6, 1e-6),
                    FirstAxis = new Vector(1, 0, 0),
                    SecondAxis = new Vector(0, 1, 0),
                    ThirdAxis = new Vector(0, 0, 1),
                },
            };
            rigid.Motion.Position = new Vector(0.08, 0.08, 0.3);
            rigid.Motion.Momentum.Z = 0.01;
            var members = new[] { new Member { Body = falling }, new Member { Body = standing }, rigid };
            var pairs = new[]
            {
                new Pair { Second = 1, Friction = 0.5, Restitution = 0.5, Nodes = ContactNodes.First },
                new Pair { First = 2, Friction = 0.25 },
            };
            var held = falling.AtNode(3);
            var joints = new[]
            {
                new Joint
                {
                    Kind = JointKind.Cable,
                    First = 2,
                    FirstAnchor = Anchor.AtPoint(new Vector(0, 0, 0.02)),
                    SecondAnchor = Anchor.AtPlace(held),
                    Length = 0.24,
                },
            };
            var options = WorldOptions.Default;
            options.Gravity.Z = -9.81;
            options.Contacts = 128;
            using (var world = new World(members, pairs, joints, options))
            {
                var touches = new Touch[128];
                for (int i = 0; i < 24; i++)
                {
                    var report = world.Step(5);
                    Console.WriteLine("report {0} {1} {2} {3} {4}", report.Contacts, report.Pressed, report.LeftOut, report.Sweeps,
                        report.NotConverged);
                    Bits("gap", report.WorstGap, report.EnergyGivenAway);
                    Bits("energy", world.Energy());
                    Vector at;
                    Attitude turned;
                    world.Pose(2, out at, out turned);
                    Bits("pose", at.X, at.Y, at.Z, turned.W, turned.X, turned.Y, turned.Z);
                    var m = world.MotionOf(2);
                    Bits("motion", m.Position.X, m.Position.Y, m.Position.Z, m.Attitude.W, m.Attitude.X, m.Attitude.Y, m.Attitude.Z,
                        m.Momentum.X, m.Momentum.Y, m.Momentum.Z, m.AngularMomentum.X, m.AngularMomentum.Y, m.AngularMomentum.Z);
                    Bits("speed", world.InSpace(0, ref held, Field.Velocity));
                    Bits("joint", world.JointOf(0).Load);
                    int found = world.Touches(touches);
                    for (int k = 0; k < found && k < touches.Length; k++)
                    {
                        var t = touches[k];
                        Console.WriteLine("touch {0} {1}", t.First, t.Second);
                        Bits("touch", t.Position.X, t.Position.Y, t.Position.Z, t.Normal.X, t.Normal.Y, t.Normal.Z, t.Force.X,
                            t.Force.Y, t.Force.Z, t.Pressure, t.Gap, t.Slip.X, t.Slip.Y, t.Slip.Z);
                    }
                    var saved = world.Save();
                    var bytes = new byte[8 * saved.Length];
                    Buffer.BlockCopy(saved, 0, bytes, 0, bytes.Length);
                    Hashed("saved", bytes);
                }
            }
        }
    }

    private static void Size<T>() => Console.WriteLine("size {0}", Marshal.SizeOf(typeof(T)));

    private static int Main(string[] arguments)
    {
        Size<BodyOptions>();
        Size<Counts>();
        Size<Place>();
        Size<Parameter>();
        Size<RigidBody>();
        Size<Motion>();
        Size<CarriedEnergies>();
        Size<WorldOptions>();
        Size<WorldReport>();
        Size<Touch>();
        Size<JointState>();
        Size<Pair>();
        Size<Anchor>();
        Size<Joint>();
        Size<Native.MemberOf>();
        Size<Native.QuantityRow>();
        for (int i = 2; i < arguments.Length; i++)
        {
            March(arguments[i], Precision.Double);
            March(arguments[i], Precision.Single);
        }
        Together(arguments[0], arguments[1]);
        return 0;
    }
}
